"""Module to Scene: names bound, numbers in SI units, presets merged, every finding reported."""
