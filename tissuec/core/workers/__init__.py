"""One function for many items: in this process, in processes, or by a dask scheduler."""
