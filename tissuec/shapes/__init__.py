"""Shapes from elsewhere: repair, inside and outside, and what stiffness their edges get."""
