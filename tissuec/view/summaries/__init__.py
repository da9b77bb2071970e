"""Texts about runs and plans that all commands share."""
