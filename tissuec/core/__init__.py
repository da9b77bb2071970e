"""Ground floor: sources and spans, diagnostics, units, families, resources."""
