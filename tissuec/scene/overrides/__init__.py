"""Values from outside the text: from ``--set`` and from Python."""
