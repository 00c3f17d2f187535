"""Building blocks of control laws: surfaces, reaching laws, adaptation, allocation."""
