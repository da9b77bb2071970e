"""Laws of the force of a spring at an elongation."""
