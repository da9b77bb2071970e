"""The atlas: one page about tissues, with what the laboratory measured of each of them."""
