"""Label images for tests, and writers of both formats: NRRD as text of its own, and nibabel."""

import gzip
from pathlib import Path

import numpy as np

CENTRE = np.array([10.0, -20.0, 30.0])  # [mm], left, back, head
RADIUS = 12.0
BALL = 4.0 / 3.0 * np.pi * RADIUS**3
NAMES = ("liver", "Tumör")
TURNED = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]


def ball(voxel, turn=None, flip=False):
    """Return a ball of two labels in a box of 40 mm: labels, axes and origin [mm]."""
    shape = [round(40.0 / side) for side in voxel]
    axes = (np.eye(3) if turn is None else turn) @ np.diag(voxel)
    axes = axes * (-1.0 if flip else 1.0, 1.0, 1.0)
    origin = CENTRE - axes @ ((np.array(shape) - 1.0) / 2.0)
    place = np.indices(shape).reshape(3, -1).T @ axes.T + origin - CENTRE
    inside = np.linalg.norm(place, axis=1) < RADIUS
    labels = (inside * (1 + (place[:, 0] > 0.0))).astype(np.uint8).reshape(shape)
    return labels, axes, origin


def write_nrrd(path: Path, labels, axes, origin, *, space="left-posterior-superior", more=()):
    """Write an image whose axes are those of a space, compressed."""
    kinds = {"uint8": "uint8", "int16": "int16", "float32": "float", "uint16": "uint16"}
    vectors = " ".join("({})".format(",".join(map(repr, row))) for row in axes.T.tolist())
    lines = [
        "NRRD0005",
        f"type: {kinds[labels.dtype.name]}",
        f"dimension: {labels.ndim}",
        f"space: {space}",
        f"sizes: {' '.join(map(str, labels.shape))}",
        f"space directions: {'none ' * (labels.ndim - 3)}{vectors}",
        f"space origin: ({','.join(map(repr, origin.tolist()))})",
        "endian: little",
        "encoding: gzip",
        *more,
    ]
    data = gzip.compress(labels.tobytes(order="F"), 1)
    path.write_bytes("\n".join([*lines, "", ""]).encode() + data)


def segments(names=NAMES):
    """Return how 3D Slicer names labels from 1 on."""
    for number, name in enumerate(names):
        yield f"Segment{number}_LabelValue:={number + 1}"
        yield f"Segment{number}_Name:={name}"


def write_nifti(path: Path, labels, axes, origin, *, unit="mm", code=1):
    """Write an image whose axes are left, back and head as NIfTI has it: right, front, head."""
    import nibabel

    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = axes, origin
    image = nibabel.Nifti1Image(labels, np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine)
    image.header.set_xyzt_units(unit)
    image.set_sform(image.affine, code)
    image.set_qform(image.affine, code)
    image.to_filename(path)
