"""Plain values: the network, its topology, and time profiles."""
