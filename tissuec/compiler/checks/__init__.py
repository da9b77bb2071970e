"""Checks of a compiled scene: one small generator per rule, each yields diagnostics."""
