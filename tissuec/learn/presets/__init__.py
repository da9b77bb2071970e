"""What was learnt as a text of the language: presets, vocabularies, tables."""
