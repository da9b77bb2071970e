"""Planes that cut bodies open in pages and pictures."""
