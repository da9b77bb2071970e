"""The player: a result as one HTML page that moves, or as pictures."""
