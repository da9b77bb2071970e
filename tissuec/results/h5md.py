"""The H5MD view of a result: nodes as particles, under the names of that format.

De Buyl, Colberg and Höfling, "H5MD: a structured, efficient, and portable file format for
molecular data", Comput. Phys. Commun. 185 (2014) 1546. The views are virtual datasets, whose
size is fixed: they are made when a file is closed, and removed when its run resumes. Their
``unit`` is an attribute of the group of each quantity: MDAnalysis refuses a ``value`` whose own
``unit`` is metres or newtons, even if it need not convert it.
"""

from collections.abc import Iterable
from typing import Any

import h5py
import numpy as np

from tissuec.core.version import __version__
from tissuec.results.datasets import DatasetSpec
from tissuec.results.fields import FieldChannel
from tissuec.results.frame_columns import MOTION, column_of
from tissuec.results.hdf5 import add_virtual, set_attribute
from tissuec.results.schema import PARTICLES
from tissuec.results.store import describe

GROUPS = ("h5md", "particles")


def add_views(
    file: h5py.File,
    fields: Iterable[FieldChannel],
    *,
    author: str,
    mass: np.ndarray,
    ids: np.ndarray,
) -> None:
    """Add the H5MD view of all frames of ``file``.

    Args:
        file: A result file, all of whose frames are shown.
        fields: What its frames contain; those of nodes are shown.
        author: Who made it, for readers; need not be known.
        mass: Masses of the nodes shown [kg], shape (node,).
        ids: Their ids, shape (node,).
    """
    remove_views(file)
    _write_head(file.create_group("h5md"), author)
    particles = file.create_group("particles/all")
    box = particles.create_group("box")
    box.attrs["dimension"] = 3
    set_attribute(box, "boundary", ["none"] * 3, h5py.string_dtype("ascii", 4))
    for name, data in (("mass", mass), ("id", ids)):
        _add(particles, PARTICLES[name], name, data)
    steps: Any = file["VTKHDF/Steps"]
    frames, nodes = int(steps.attrs["NSteps"]), len(mass)
    first: Any = steps["PointOffsets"][:frames]
    if not frames or not nodes:
        return  # HDF5 has no virtual datasets without content
    step = np.arange(frames)
    for channel in (*MOTION, *(one for one in fields if one.at == "node")):
        view = particles.create_group(channel.key)
        view.attrs["unit"] = channel.unit
        source: Any = file[column_of(channel).path]
        value = add_virtual(view, "value", source, (frames, nodes, *channel.row), first)
        declared = PARTICLES["{field}/value"].of(field=channel.key, unit=channel.unit)
        value.attrs["description"] = declared.text
        view["time"] = steps["Values"]  # the same dataset under a second name
        _add(view, PARTICLES["{field}/step"], "step", step)


def remove_views(file: h5py.File) -> None:
    """Remove the H5MD view, if there is one."""
    for name in GROUPS:
        if name in file:
            del file[name]


def _add(group: h5py.Group, declared: DatasetSpec, name: str, data: np.ndarray) -> None:
    describe(group.create_dataset(name, data=data), declared.unit, declared.text)


def _write_head(group: h5py.Group, author: str) -> None:
    group.attrs["version"] = np.array([1, 1])
    group.create_group("author").attrs["name"] = author
    creator = group.create_group("creator")
    creator.attrs["name"] = "tissuec"
    creator.attrs["version"] = __version__
