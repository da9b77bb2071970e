"""Learning: from measured motion to numbers of a preset, and how sure they are."""
