"""Tensors of solid elements: means over each of them."""

from typing import Any

import numpy as np

from tissuec.core import units
from tissuec.mechanics.deformation import six
from tissuec.model.cut_cells import solid_entities
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.script.measures.snapshot import Snapshot


class TensorOfElements(FrameField):
    """Base of tensors of elements."""

    at = "element"
    width = 6
    needs = ("elements",)

    @staticmethod
    def numbers(elements: Any, position: Floats, drawn: Floats) -> Floats:
        """Return tensors in the SI unit, shape (element, 3, 3).

        Args:
            elements: A ``forces.solids.elements.SolidElements`` that recalls its memory.
            position: Of all nodes [m], shape (node, 3).
            drawn: The same before the run.
        """
        raise NotImplementedError

    @classmethod
    def sample(cls, snapshot: Snapshot) -> Floats:
        state, every = snapshot.state, snapshot.state.of_kind("elements")
        entities = solid_entities(state.network)
        at = np.zeros(state.network.entity_count, dtype=np.int64)
        at[entities] = np.arange(len(entities))
        found = np.zeros((*np.shape(snapshot.time), len(entities), 6))
        position, velocity = (
            one.reshape(-1, *one.shape[-2:]) for one in (snapshot.position, snapshot.velocity)
        )
        drawn = state.network.position
        rows = found.reshape(len(position), len(entities), 6)
        for row, places, speeds in zip(rows, position, velocity, strict=True):
            for each in every:
                there = np.flatnonzero(state.alive[each.walls])
                own = each.recalling(speeds).only(there)
                row[at[each.walls[there]]] = six(cls.numbers(own, places, drawn))
        return found


@FIELDS.member("stress tensor")
class StressTensorField(TensorOfElements):
    dimension = units.PRESSURE
    text = "mean Cauchy stress of each solid element"
    stored = "stress"
    remark = "Its components are xx, yy, zz, xy, yz and xz, without viscous stress."

    @staticmethod
    def numbers(elements: Any, position: Floats, drawn: Floats) -> Floats:
        return elements.mean_stress(position)


@FIELDS.member("strain tensor")
class StrainTensorField(TensorOfElements):
    dimension = units.NUMBER
    text = "mean Green-Lagrange strain of each solid element"
    stored = "strain"
    remark = "Its components are xx, yy, zz, xy, yz and xz; from the shape as drawn."

    @staticmethod
    def numbers(elements: Any, position: Floats, drawn: Floats) -> Floats:
        return elements.shape.mean_strain(position[elements.nodes], drawn[elements.nodes])
