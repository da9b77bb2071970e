"""Cells that surfaces divide into parts, each with a copy of the nodes of the cell."""
