"""Precisions in which frames are stored."""

SINGLE = "single"
PRECISIONS = {SINGLE: "24 binary digits", "double": "53 binary digits"}
