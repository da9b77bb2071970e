"""Precisions in which frames are stored."""

SINGLE = "single"
PRECISIONS = (SINGLE, "double")
