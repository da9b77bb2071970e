"""Reading of blocks, entries, sentences and expressions by their declarations."""
