"""Laws of what a dashpot pulls with at a speed."""
