"""The spacecraft: body, wheels with friction, wheel layouts and catalogue, flexible appendages."""
