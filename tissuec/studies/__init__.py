"""Studies: many runs of one scene, each a row of one table."""
