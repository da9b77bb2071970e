"""Blocks files: a result as parts of bodies, joints and instruments, for VTK and ParaView.

    Trajectory, Anatomy ── blocks_of ──> ResultBlock, Cloud   parts, and what they draw
       │
       └── CloudMoments ── fields ─────> arrays               at points and cells of a frame

``write_blocks`` writes one VTKHDF file with all frames, ``write_pieces`` numbered files of VTK
XML. Fields of frames are shown by themselves; a derived one is added in ``fields.py`` alone.
"""
