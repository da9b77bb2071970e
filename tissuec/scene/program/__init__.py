"""Programs: files and their imports, what they declare, and the order in which it is needed."""
