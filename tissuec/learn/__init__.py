"""Learning: from measured motion to numbers of a preset, with their uncertainty."""
