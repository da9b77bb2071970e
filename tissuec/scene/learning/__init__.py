"""Learn blocks, as far as they need no mesh."""
