"""Output for people: pages, pictures, plots, reports and comparisons."""
