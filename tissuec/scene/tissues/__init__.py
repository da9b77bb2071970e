"""Tissues: words and numbers of presets turned into quantities, and what is known of them."""
