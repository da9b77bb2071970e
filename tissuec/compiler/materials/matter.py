"""From matter to springs: spring constants per pascal and masses per density.

Solids get springs that pass the patch test as nearly as they can. Those of a crystal are scaled
to the Young's modulus that virtual tests in tension find, those of other nets calibrated by
tests in tension and shear (``matter.solid_springs``). Surfaces get those of ``matter.surface``,
times the thickness of the body; threads and explicit nets are bars with a section.
"""

from hashlib import sha256
from math import pi
from operator import attrgetter
from typing import NoReturn

import numpy as np
from msgspec import Struct

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.core.errors import Note
from tissuec.core.keeping import kept_by
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.matter.elasticity import wall_springs
from tissuec.matter.plate import RIGIDITY, Plate, plate
from tissuec.matter.solid import Fibres, Solid
from tissuec.matter.solid_springs import (
    POISSON_OF_BRACED,
    calibrated,
    fitted,
    fitted_block,
    sample_of,
)
from tissuec.matter.surface import surface
from tissuec.matter.traction import POISSON, Floppy, MeasuredStiffness, measured
from tissuec.meshes.generators import Mesh, Threaded
from tissuec.meshes.generators.lattice import Lattice
from tissuec.model.network import Floats
from tissuec.scene.bodies.fibres import AXIAL, Helix
from tissuec.scene.reading.findings import Findings

POISSON_OF_SURFACE = 1.0 / 3.0
UNEVEN = 0.1  # how much the stiffness of a mesh may depend on the direction, untold
_OF_TUBES = "only those of a tube are axial or circumferential"
_ACROSS = 0.1  # part of a direction that must lie within a sheet
_TESTED = 300_000  # springs of a solid up to which it is tested; of larger lattices, a part


class Matter(Struct, frozen=True, eq=False):
    """Distribution of a body to its springs and nodes.

    Attributes:
        stiffness: Spring constant per Young's modulus [m], shape (spring,).
        volume: Of each node [m³], shape (node,).
        poisson: Poisson's ratio that springs alone give; None where there is none.
        is_solid: Whether Poisson's ratio can be raised by keeping the volume.
        hinges: Of a shell, with constants per Young's modulus [m³].
    """

    stiffness: Floats
    volume: Floats
    poisson: float | None
    is_solid: bool = False
    hinges: Plate | None = None

    @property
    def tearing(self) -> float:
        """Return the energy of a spring at which it breaks, per toughness and c L / E.

        Springs of all directions have sections c L / E that add up to 6 V / L in a solid and to
        3 V / L in a wall, and cross an area by |cos| of their angle to its normal: by 1/2 and
        2/π on average. So an area is crossed by 3 and 6/π times as much section. Half of the
        toughness is what they hold: a crack between springs needs twice as much to grow, and
        the rest goes into vibrations.
        """
        if self.poisson is None:
            return 1.0
        return 0.5 / 3.0 if self.is_solid else 0.5 * pi / 6.0

    @property
    def shears(self) -> float:
        """Return Young's modulus over the shear modulus of springs alone, as in a solid."""
        return 2.0 * (1.0 + (self.poisson if self.poisson and self.is_solid else POISSON))


class _Drawn:
    """A solid as it is drawn.

    Attributes:
        digest: Equal to those of others that have the same nodes, springs and fibres.
    """

    def __init__(self, mesh: Mesh, solid: Solid, generator: object, fibres: Fibres | None):
        self.mesh, self.solid, self.generator, self.fibres = mesh, solid, generator, fibres
        is_braced = isinstance(generator, Lattice) and generator.is_braced
        self.poisson = POISSON_OF_BRACED if is_braced else POISSON
        found = sha256(type(generator).__qualname__.encode())
        stiffness = () if fibres is None else (fibres.stiffness,)
        for array in (mesh.position, mesh.ends, solid.volume, *stiffness):
            found.update(np.ascontiguousarray(array).data)
        self.digest = found.hexdigest()


DIGEST = attrgetter("digest")


@kept_by(DIGEST, 4)  # learning compiles a scene many times, with other numbers
def _fitted(drawn: _Drawn) -> Floats:
    """Return the constants of springs per Young's modulus, before any test [m].

    Raises:
        ValueError: There are fibres in springs of too few directions.
    """
    mesh, solid, fibres = drawn.mesh, drawn.solid, drawn.fibres
    if isinstance(drawn.generator, Lattice):
        constant = fitted_block(drawn.generator, mesh, fibres)
    else:
        constant = fitted(mesh.position, mesh.ends, solid, fibres)
    return constant / (2.0 * (1.0 + drawn.poisson))


@kept_by(DIGEST, 4)
def _tested(drawn: _Drawn) -> tuple[Floats, MeasuredStiffness]:
    """Return the constants of springs per Young's modulus [m], and what tests of them found.

    Springs of a crystal are multiplied by one number.

    Raises:
        Floppy: Nothing resists one of the stresses.
        ValueError: As for ``_fitted``.
    """
    mesh, solid, fibres = drawn.mesh, drawn.solid, drawn.fibres
    if not isinstance(drawn.generator, Lattice):
        return calibrated(mesh.position, mesh.ends, solid, fibres)
    constant = _fitted(drawn)
    found = measured(mesh.position, mesh.ends, constant, solid, drawn.poisson, fibres)
    scale = 1.0 / float(found.tension.mean())
    return scale * constant, found.times(scale)


def can_be_matter(drawing: Drawing) -> bool:
    """Return whether a mesh has springs as matter needs them.

    Nets typed in as tables could have a section, but are what they are on purpose.
    """
    mesh = drawing.mesh
    is_tube = mesh.grid is not None and mesh.grid.closed
    if drawing.thread is not None or mesh.volume is not None or is_tube:
        return True
    return bool(len(mesh.skin) and wall_springs(mesh.skin, mesh.ends[: drawing.own]).all())


class MatterReader:
    """Finds how the matter of one body is shared out.

    Args:
        span: What needs it, such as a Young's modulus.
    """

    def __init__(self, drawing: Drawing, span: Span, findings: Findings):
        self.drawing, self.body = drawing, drawing.body
        self.span, self.findings = span, findings
        self.fibres: Span = span  # the entry that needs their direction
        self._added = 0.0
        self._is_told = False  # that the mesh is not isotropic

    def read(self, added: float = 0.0) -> Matter:
        """Return the shares of the body; missing quantities are reported with their place.

        Args:
            added: What fibres add to Young's modulus, as a part of it.
        """
        self._added = added
        mesh = self._own()
        if isinstance(self.body.mesh, Threaded):
            self._refuse("thickness", "section")
            return self._bars(pi * self.body.mesh.thread_radius() ** 2)
        if mesh.volume is not None:
            self._refuse("thickness", "section")
            return self._solid(mesh, mesh.volume)
        if len(mesh.skin):
            self._refuse("section")
            return self._surface(mesh)
        self._refuse("thickness")
        if self.body.section is None:
            self._missing("section", "area of the section of each spring", "section = 1 mm^2")
        return self._bars(self.body.section)

    def _own(self) -> Mesh:
        """Return the mesh without springs that knot it or resist bending."""
        drawing = self.drawing
        ends = drawing.mesh.ends[: drawing.own]
        return drawing.mesh.with_ends(ends)

    # --- kinds of bodies ----------------------------------------------------------------------

    def _bars(self, section: float) -> Matter:
        length = self.drawing.length
        if not length.all():
            self.findings.reject(
                "TIS309",
                f"a spring of {self.body.name} has zero length, so it cannot be made of matter",
                self.body.span,
                hint="give it a tissue with a spring constant, such as 20 kN/m: springs "
                "between nodes at the same position then hold these together",
                notes=self._notes(),
            )  # fmt: skip
        pieces = slice(None) if self.drawing.thread is None else self.drawing.thread.pieces
        half = np.repeat(length[pieces] / 2.0, 2)
        along = np.bincount(
            self.drawing.mesh.ends[pieces].ravel(), half, len(self.drawing.mesh.position)
        )
        volume: Floats = section * along  # pyright: ignore[reportAssignmentType]  # floats, unlike its stub
        return Matter((1.0 + self._added) * section / length, volume, None)

    def _surface(self, mesh: Mesh) -> Matter:
        if self.body.thickness is None:
            self._missing("thickness", "thickness of its wall", "thickness = 1 mm")
        thickness = self.body.thickness
        try:
            found = surface(mesh, self._fibres_in_wall(mesh) if self._added else None)
        except ValueError as error:
            self._impossible(str(error), "choose a mesh whose springs lie in its surface")
        self._warn_if_uneven(
            found.range,
            "use triangles that are nearly equilateral"
            if mesh.even_grid is None
            else "write diagonals is both, and draw cells up to 1.7 times as long as wide",
        )
        stiffness = self._with_bending(thickness * found.constant)
        hinges = self._hinges(mesh, thickness) if self.body.shell else None
        return Matter(stiffness, thickness * found.area, POISSON_OF_SURFACE, hinges=hinges)

    def _hinges(self, mesh: Mesh, thickness: float) -> Plate:
        found = plate(mesh)
        if not len(found.nodes):
            self._impossible(
                "its mesh is too coarse to bend", "use three rows and columns of nodes or more"
            )
        return replace(found, constant=RIGIDITY * thickness**3 * found.constant)

    def _solid(self, mesh: Mesh, volume: Floats) -> Matter:
        if not np.all(volume > 0.0):
            self._impossible(
                "the volume of its cells cannot be computed",
                "use tetrahedra, a lattice, or a closed surface with a filling",
            )
        generator, fibres = self.body.mesh, self._fibres_in_solid() if self._added else None
        scale = 1.0
        if isinstance(generator, Lattice) and (there := self.body.whole_placement) is not None:
            # Springs are as stiff as those of the lattice that its entries describe, times the
            # scale; a lattice that is distorted is a net like any other.
            if there.scale is None:
                generator = None
            else:
                scale, mesh = there.scale, generator.build()
                if fibres is not None:
                    back = there.inverse().direction(fibres.direction)
                    fibres = replace(fibres, direction=back)
        assert mesh.volume is not None
        solid = Solid.of(mesh.position, mesh.volume, mesh.skin)
        drawn = _Drawn(mesh, solid, generator, fibres)
        try:
            stiffness = scale * self._springs(drawn)
        except ValueError as error:
            self._impossible(str(error), "choose another kind of lattice")
        return Matter(self._with_bending(stiffness), volume, drawn.poisson, is_solid=True)

    def _springs(self, drawn: _Drawn) -> Floats:
        """Return spring constants per Young's modulus [m]; raises ValueError as ``_fitted``."""
        if len(drawn.mesh.ends) <= _TESTED:
            return self._calibrated(drawn)
        if not isinstance(drawn.generator, Lattice):
            return _fitted(drawn)
        small = sample_of(drawn.generator)
        few = small.build()
        assert few.volume is not None
        part = Solid.of(few.position, few.volume, few.skin)
        sample = _Drawn(few, part, small, drawn.fibres)
        return self._calibrated(sample).sum() / _fitted(sample).sum() * _fitted(drawn)

    def _calibrated(self, drawn: _Drawn) -> Floats:
        """Return spring constants per Young's modulus that give a body its own [m]."""
        try:
            stiffness, found = _tested(drawn)
        except Floppy as error:
            self._impossible(
                f"{error} in its mesh",
                "connect more distant nodes, for example: reach is second neighbours",
            )
        limits = found.least, found.largest
        self._warn_if_uneven(limits, "connect more distant nodes, or use smaller cells")
        return stiffness

    # --- fibres -------------------------------------------------------------------------------

    def _direction(self) -> Floats | str:
        if self.body.fibres is None:
            self.span = self.fibres
            self._missing("fibres", "direction of its fibres", "fibres = (1, 0, 0)")
        if isinstance(self.body.fibres, Helix):
            self._refuse_fibres("an angle around a tube is for elements")
        return self.body.fibres

    def _fibres_in_solid(self) -> Fibres:
        direction = self._direction()
        if isinstance(direction, str):
            self._refuse_fibres(_OF_TUBES)
        return Fibres(direction, self._added)

    def _fibres_in_wall(self, mesh: Mesh) -> Fibres:
        """Return fibres in a grid, along its rows and at right angles to them."""
        direction, grid = self._direction(), mesh.even_grid
        if grid is None:
            self._refuse_fibres(
                "in a wall, they need springs in even rows, as in a sheet or a straight tube"
            )
        side, other = mesh.position[[1, grid.columns]] - mesh.position[0]
        if not grid.closed:
            if isinstance(direction, str):
                self._refuse_fibres(_OF_TUBES)
            first = side / np.linalg.norm(side)
            second = other - (other @ first) * first
            within = np.array([direction @ first, direction @ second / np.linalg.norm(second)])
            if (length := float(np.linalg.norm(within))) < _ACROSS:
                self._refuse_fibres("they are perpendicular to the sheet")
            return Fibres(within / length, self._added)
        if not isinstance(direction, str):
            along = abs(float(direction @ other)) / float(np.linalg.norm(other))
            if along < 1.0 - 1e-6:
                self._refuse_fibres("in a tube, they run along its axis or around it")
            direction = AXIAL
        return Fibres(np.array([0.0, 1.0] if direction == AXIAL else [1.0, 0.0]), self._added)

    def _refuse_fibres(self, why: str) -> NoReturn:
        self.findings.reject(
            "TIS309", f"{self.body.name} cannot have these fibres: {why}",
            self.body.places.get("fibres", self.body.span),
            hint="write fibres = (1, 0, 0), or, in a tube, fibres is axial or circumferential",
            notes=self._notes(),
        )  # fmt: skip

    def _with_bending(self, stiffness: Floats) -> Floats:
        """Return spring constants also of springs that resist bending.

        They are as stiff as springs of their length would be that are made like those beside.
        """
        bends = self.drawing.bends
        if not bends.any():
            return stiffness
        length, ends, own = self.drawing.length, self.drawing.mesh.ends, self.drawing.own
        count = len(self.drawing.mesh.position)
        both = ends[:own].ravel()
        pull = np.repeat(stiffness * length[:own], 2)
        mean = np.bincount(both, pull, count) / np.maximum(
            np.bincount(both, minlength=count), 1
        )
        return np.concatenate([stiffness, mean[ends[own:]].mean(axis=1) / length[own:]])

    # --- findings -----------------------------------------------------------------------------

    def _notes(self) -> tuple[Note, ...]:
        return (Note("required by this entry", self.span),)

    def _missing(self, entry: str, what: str, example: str) -> NoReturn:
        self.findings.reject(
            "TIS304", f'{self.body.name} needs "{entry}": the {what}', self.body.span,
            hint=f"for example: {example}", notes=self._notes(),
        )  # fmt: skip

    def _refuse(self, *entries: str) -> None:
        """Reject entries that say nothing of a body like this."""
        for entry in entries:
            if getattr(self.body, entry) is not None:
                self.findings.reject(
                    "TIS306", f'body {self.body.name} cannot have "{entry}"',
                    self.body.places.get(entry, self.body.span),
                    hint=f"remove {entry}: the mesh already defines its dimensions",
                )  # fmt: skip

    def _impossible(self, why: str, hint: str) -> NoReturn:
        self.findings.reject(
            "TIS309", f"body {self.body.name} cannot be made of matter: {why}", self.body.span,
            hint=hint, notes=self._notes(),
        )  # fmt: skip

    def _warn_if_uneven(self, limits: tuple[float, float], hint: str) -> None:
        """Tell how much a stiffness depends on the direction, per the one given."""
        uneven = max(abs(limit - 1.0) for limit in limits) > UNEVEN
        if uneven and not self._is_told:
            self._is_told = True
            self.findings.add(
                "W207",
                f"the mesh of {self.body.name} is not isotropic: depending on the direction, "
                f"its stiffness is {limits[0]:.2f} to {limits[1]:.2f} times the given one",
                self.body.span, hint=hint, notes=self._notes(),
            )  # fmt: skip
