"""Measures and conditions over them, checked now and evaluated later."""
