"""Predictions of experiments, with exact derivatives of every step and equilibrium."""
