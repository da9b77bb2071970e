"""Studies of a compiled scene."""
