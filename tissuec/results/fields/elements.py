"""Fields of elements: numbers of their points, of which a node has the mean around it."""

from typing import Any, ClassVar

import numpy as np

from tissuec.core import units
from tissuec.mechanics.deformation import six, von_mises
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.script.measures import Subject
from tissuec.script.measures.points import around_nodes, at_points
from tissuec.script.measures.snapshot import Snapshot


class FieldOfElements(FrameField):
    """Base of fields of elements."""

    at = "node"
    of_points = True
    needs: ClassVar[tuple[str, ...]] = ("elements",)

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        """Return numbers in the SI unit, shape (element, point).

        Args:
            elements: A ``forces.point_fields.PointField`` that recalls its memory.
            position: Of all nodes [m], shape (node, 3).
        """
        raise NotImplementedError

    @classmethod
    def sample(cls, snapshot: Snapshot) -> Floats:
        return around_nodes(snapshot, cls.numbers)

    @classmethod
    def of(cls, subject: Subject, snapshot: Snapshot) -> tuple[Floats, Floats]:
        return at_points(snapshot, snapshot.nodes(subject), cls.numbers)


@FIELDS.member("von Mises stress")
class VonMisesStress(FieldOfElements):
    dimension = units.PRESSURE
    text = "equivalent stress of von Mises in the elements around each node"
    remark = "Nodes have the mean by volume, without viscous stress, and 0 without elements."
    stored = "von_mises_stress"

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return von_mises(six(elements.stresses(position)))


@FIELDS.member("largest principal stress")
class LargestPrincipalStressField(FieldOfElements):
    dimension = units.PRESSURE
    text = "largest principal Cauchy stress in the elements around each node"
    signed = True
    remark = "See `von Mises stress`."

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return np.linalg.eigvalsh(elements.stresses(position))[..., -1]


@FIELDS.member("smallest principal stress")
class SmallestPrincipalStressField(FieldOfElements):
    dimension = units.PRESSURE
    text = "smallest principal Cauchy stress in the elements around each node"
    signed = True
    remark = "See `von Mises stress`."

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return np.linalg.eigvalsh(elements.stresses(position))[..., 0]


@FIELDS.member("hydrostatic pressure")
class HydrostaticPressureField(FieldOfElements):
    dimension = units.PRESSURE
    text = "minus a third of the trace of the stress in the elements around each node"
    signed = True
    remark = "See `von Mises stress`."

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return np.trace(elements.stresses(position), axis1=-2, axis2=-1) / -3.0


@FIELDS.member("largest principal strain")
class LargestPrincipalStrain(FieldOfElements):
    dimension = units.NUMBER
    text = "largest principal strain λ - 1 in the elements around each node"
    signed = True
    remark = (
        "λ is a principal stretch from the shape without stress, as for a breaking strain. In "
        "a wall, it is one in the plane. The logarithmic strain is log(1 + e), that of Green "
        "and Lagrange e + e²/2."
    )

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return elements.principal_stretches(position)[..., 0] - 1.0


@FIELDS.member("smallest principal strain")
class SmallestPrincipalStrain(FieldOfElements):
    dimension = units.NUMBER
    text = "smallest principal strain λ - 1 in the elements around each node"
    signed = True
    remark = "See `largest principal strain`."

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return elements.principal_stretches(position)[..., -1] - 1.0


@FIELDS.member("plastic strain")
class PlasticStrainField(FieldOfElements):
    dimension = units.NUMBER
    text = "plastic strain of the elements around each node"
    remark = "It is that of the measure of this name, and 0 where nothing yields."

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return elements.plastic_strains


@FIELDS.member("modulus")
class ModulusField(FieldOfElements):
    dimension = units.PRESSURE
    text = "mean Young's modulus at rest of the elements around each node"
    remark = "The mean is by volume, without fibres, and 0 where there is no element."

    @staticmethod
    def numbers(elements: Any, position: Floats) -> Floats:
        return np.broadcast_to(elements.young[:, None], (elements.item_count, elements.points))
