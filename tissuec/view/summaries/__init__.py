"""Texts about scenes and plans that commands and pages share."""
