"""The atlas: one page about tissues, with the laboratory measurements of each."""
