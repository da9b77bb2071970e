"""Fields of frames: numbers per node, spring, triangle or cell over time.

A member is a class that is never instantiated. It says what a field is and computes it during a
run. Everything else goes over the family: the columns of files and their size, arrays in
Python, tables, blocks, colours of pages and plots, and the reference.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, ClassVar, Literal, TypeAlias

import numpy as np
from msgspec import Struct

from tissuec.core.names import key_of
from tissuec.core.registry import Family
from tissuec.core.units import Dimension, si_unit
from tissuec.forces.acting import FORCES, ForceOutput
from tissuec.model.cut_cells import solid_entities
from tissuec.model.network import Floats
from tissuec.script.measures import Subject
from tissuec.script.measures.snapshot import Snapshot

if TYPE_CHECKING:
    from tissuec.forces.enclosed.volume import Enclosure

#: What has a number: a node, a spring, a triangle of the skin, a cell of a preserved volume, or
#: a solid element.
Place: TypeAlias = Literal["node", "spring", "triangle", "cell", "element"]


class FrameField:
    """Base of the members of ``FIELDS``.

    Attributes:
        at: What has a number, or a vector.
        dimension: Of the numbers.
        text: What they are, such as "tension of each spring".
        width: 1, 3 of vectors at nodes, or 6 of tensors: xx, yy, zz, xy, yz, xz.
        signed: Whether numbers below 0 have a meaning of their own; colours then part at 0.
        always: Whether each trajectory contains it; a scene asks for the others.
        stored: Name of its array in files; its own name if empty.
        remark: Further sentences for the reference.
        of_force: The kind of the forces that it is about, if it is an output of these.
        needs: What must be shown for it to have a meaning, names of ``NEEDS`` of measures.
        of_points: Whether elements have numbers at their points, of which nodes have the mean.
    """

    at: ClassVar[Place]
    dimension: ClassVar[Dimension]
    text: ClassVar[str]
    width: ClassVar[Literal[1, 3, 6]] = 1
    signed: ClassVar[bool] = False
    always: ClassVar[bool] = False
    stored: ClassVar[str] = ""
    remark: ClassVar[str] = ""
    of_force: ClassVar[str] = ""
    needs: ClassVar[tuple[str, ...]] = ()
    of_points: ClassVar[bool] = False

    @staticmethod
    def sample(snapshot: Snapshot) -> Floats:
        """Return the numbers at some times in the SI unit.

        Returns:
            Numbers of shape (…, node), (…, node, 3), (…, spring), (…, triangle of the skin of
            the network), (…, cell) of the volumes that are preserved then, see
            ``over_cells``, or (…, element) of all ``solid_entities``.
        """
        raise NotImplementedError

    @classmethod
    def of(cls, subject: Subject, snapshot: Snapshot) -> tuple[Floats, Floats]:
        """Return the numbers of a subject, and by how much each of them counts.

        Triangles, cells and elements belong to it if all of their nodes do. Of vectors and
        tensors, it is the magnitude.

        Returns:
            In the SI unit, shape (…, n), and shape (n,): the drawn volumes of cells and
            elements [m³]; all others count alike.
        """
        state, numbers = snapshot.state, cls.sample(snapshot)
        if cls.width > 1:
            numbers = magnitudes(numbers)
        nodes = snapshot.nodes(subject)
        if cls.at == "node":
            return numbers[..., nodes], np.ones(len(nodes))
        if cls.at == "spring":
            springs = snapshot.intact_springs(subject)
            return numbers[..., springs], np.ones(len(springs))
        inside = np.zeros(state.network.node_count, dtype=bool)
        inside[nodes] = True
        if cls.at == "triangle":
            own = inside[state.network.skin].all(axis=1)
            return numbers[..., own], np.ones(int(own.sum()))
        if cls.at == "element":
            entities = solid_entities(state.network)
            volume = np.zeros(state.network.entity_count)
            for each in state.of_kind("elements"):
                own = inside[each.nodes].all(axis=1) & state.alive[each.walls]
                volume[each.walls[own]] = each.volume[own]
            chosen = volume[entities] > 0.0
            return numbers[..., chosen], volume[entities[chosen]]
        cells = [each for each in state.enclosures.values() if each.item_count]
        own = [
            np.logical_and.reduceat(inside[c.corners].all(axis=1), c.first[:-1]) for c in cells
        ]
        chosen = np.concatenate([np.zeros(0, dtype=bool), *own])
        volume = np.concatenate([np.zeros(0), *(each.drawn for each in cells)])
        return numbers[..., chosen], volume[chosen]


def magnitudes(numbers: Floats) -> Floats:
    """Return the magnitudes of vectors, shape (…, 3), or of symmetric tensors, (…, 6).

    They have the unit of the numbers and the shape (…).
    """
    twice = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])[: numbers.shape[-1]]
    return np.sqrt(numbers**2 @ twice)


class FrameFields(Family[type[FrameField]]):
    """Fields by name: members of the family, and the outputs that forces declare.

    Forces take long to import. They are imported where all fields are asked for, or one that
    is no member.
    """

    @property
    def always(self) -> tuple[str, ...]:
        """Return the names of the fields that each trajectory contains, in order."""
        return tuple(name for name in sorted(self._own()) if self._own()[name].always)

    def called(self, key: str) -> str:
        """Return the name of the field that a scene calls by a key of names; "" without one."""
        return next((name for name in self if key_of(name) == key), "")

    def __getitem__(self, name: str) -> type[FrameField]:
        return self._own()[name] if name in self._own() else self._of_forces()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(sorted({*self._own(), *self._of_forces()}))

    def __len__(self) -> int:
        return len({*self._own(), *self._of_forces()})

    def _of_forces(self) -> dict[str, type[FrameField]]:
        """Return the outputs of all forces as fields.

        Raises:
            ValueError: Two fields have the same name.
        """
        found: dict[str, type[FrameField]] = {}
        for kind, force in FORCES.items():
            for output in force.outputs:
                if output.name in self._own() or output.name in found:
                    raise ValueError(f"two fields of frames are called {output.name!r}")
                found[output.name] = _field_of(kind, output)
        return found


@cache
def _field_of(kind: str, output: ForceOutput) -> type[FrameField]:
    """Return an output of the forces of a kind as a field."""

    class OfForce(FrameField):
        at = output.at
        dimension = output.dimension
        text = output.text
        signed = output.signed
        remark = output.remark
        of_force = kind

        @staticmethod
        def sample(snapshot: Snapshot) -> Floats:
            state = snapshot.state
            places = len(state.network.skin if output.at == "triangle" else state.position)
            found = np.zeros((*np.shape(snapshot.time), places))
            for field in state.of_kind(kind):
                acting = field.intact(state.alive)
                where, numbers = output.numbers(acting, snapshot.time, snapshot.position)
                # Its rows are places: a node may have several numbers.
                np.add.at(np.moveaxis(found, -1, 0), where, np.moveaxis(numbers, -1, 0))
            return found

    return OfForce


FIELDS = FrameFields("tissuec.results.fields", "frame field")


class FieldChannel(Struct, frozen=True):
    """A field as a file contains it, whether or not its member is installed.

    Attributes:
        name: Of the member.
        at: What has a number, or a vector.
        unit: SI unit; "" without one.
        width: 1, 3 of vectors at nodes, or 6 of tensors.
        text: What the numbers are.
        stored: Name of the arrays at nodes and cells of files.
        signed: Whether numbers below 0 have a meaning of their own.
    """

    name: str
    at: Place
    unit: str
    width: int
    text: str
    stored: str
    signed: bool

    @classmethod
    def of(cls, name: str) -> "FieldChannel":
        """Return the channel of a member; KeyError if there is none of that name."""
        field = FIELDS[name]
        stored = field.stored or key(name)
        unit = si_unit(field.dimension)
        return cls(name, field.at, unit, field.width, field.text, stored, field.signed)

    @property
    def key(self) -> str:
        """Return the name with underscores, as arrays of Python have it."""
        return key(self.name)

    @property
    def row(self) -> tuple[int, ...]:
        """Return the shape of the numbers at one place."""
        return (self.width,) if self.width > 1 else ()

    @property
    def adds_up(self) -> bool:
        """Return whether numbers at nodes add up, as forces do, and have no values between."""
        return self.unit == "N"

    @property
    def at_nodes(self) -> str:
        """Return the description of the single number per node that pages and plots show."""
        if self.at != "node":
            return f"{self.text}, as the mean around each node"
        return f"magnitude of the {self.text}" if self.width > 1 else self.text


def key(name: str) -> str:
    """Return a name with underscores in place of blanks."""
    return name.replace(" ", "_")


def always_recorded() -> tuple[FieldChannel, ...]:
    """Return the channels that each trajectory contains."""
    return channels(())


def channels(asked: Iterable[str]) -> tuple[FieldChannel, ...]:
    """Return the channels of a trajectory for which a scene asks for some fields by name."""
    return tuple(FieldChannel.of(name) for name in (*FIELDS.always, *asked))


def over_cells(snapshot: Snapshot, of: "Callable[[Enclosure], Floats]") -> Floats:
    """Return numbers of all cells whose volume is preserved then, shape (…, cell).

    They are in the unit of the numbers of ``of``.

    Args:
        snapshot: At one time or several.
        of: From the preserved volume of one body to the numbers of its cells, shape (…, cell).
    """
    none = np.zeros((*np.shape(snapshot.time), 0))
    each = map(of, snapshot.state.enclosures.values())
    return np.concatenate([none, *each], axis=-1)
