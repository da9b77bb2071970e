"""Blocks files: a result as parts of bodies, joints and instruments, for VTK and ParaView.

    Trajectory, Anatomy ── blocks_of ──> ResultBlock, Cloud   parts, and what they draw
       │
       └── CloudMoments ── FIELDS ─────> arrays               at points and lines of a frame

``write_blocks`` writes one VTKHDF file with all frames, ``write_pieces`` numbered files of VTK
XML. A field is added in ``fields.py`` alone.
"""
