"""What surfaces enclose: volumes, fluids, and pressure on their faces."""
