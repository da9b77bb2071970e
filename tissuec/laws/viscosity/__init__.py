"""Laws of the force of a dashpot at a speed."""
