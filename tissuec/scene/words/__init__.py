"""Words: scales of properties, hedges and rules."""
