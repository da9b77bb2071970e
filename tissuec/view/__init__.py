"""Everything that people look at: pages, pictures, plots, reports and comparisons."""
