"""Random numbers, compiled entry points, serialization, checked parameters and directions."""
