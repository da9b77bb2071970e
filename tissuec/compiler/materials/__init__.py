"""Materials: from quantities of tissues to numbers of nodes and springs."""
