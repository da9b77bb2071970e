"""Text to frozen syntax nodes and back: sentence shapes, no vocabulary."""
