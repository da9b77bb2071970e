"""Result files: one HDF5 file that ParaView, H5MD readers and plain h5py all open.

Only this package, and what reads measured data, imports h5py; ``recording``, ``journal`` and
``mesh`` do without it.
"""
