"""Analyses of the table of a study: sensitivities, orders, quantiles, effects."""
