"""Study blocks, as far as they need no mesh."""
