"""Learnt results as text."""
