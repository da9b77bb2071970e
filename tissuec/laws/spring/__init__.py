"""Laws of what a spring pulls with at an elongation."""
