"""Contact of tools, threads and bodies."""
