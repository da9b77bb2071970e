"""Costs of forces on elements, faces and volumes, as multiples of that of a spring.

The table lists the processor time of an evaluation per item on one thread: the additional time
of a scene over the same scene without the feature. Scenes alternate with the tube of springs of
the publication; the numbers are medians of ratios. A second table compares making and using the
matrix of an implicit step with an evaluation. Takes some minutes.
"""

import time
from collections.abc import Iterator
from statistics import median

import click
import numpy as np
from msgspec import Struct

from benchmarks.publishing import publish, tell, write_option
from benchmarks.stepping import build, nets
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.markdown import table
from tissuec.core.source import Source
from tissuec.engine.engine import Engine
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Method
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

REPEATS = 11
LASTS = 0.02  # processor time of one measurement, at least [s]
STEPS = 1000  # at least: each call lists the pairs of contact, which takes as long as 100 steps
STEP = 1e-10  # so short that nothing moves [s]

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = {poisson}; density = 1000 kg/m^3
  {matter} }}
body piece {{ mesh is {mesh}; tissue is gel; {body} }}
environment {{ gravity = (0, 0, 0) m/s^2; {around} }}
{more}
simulate {{ duration = 1 s }}
"""
BLOCK = "lattice { cell = 2 mm; box from (0, 0, 0) mm to (24, 24, 24) mm }"
BALL = "sphere { centre = (0, 0, 0) mm; radius = 20 mm; subdivisions = 3 }"
SHEET = {
    "mesh": "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; "
            "second edge = (0, 40, 0) mm; columns = 21; rows = 21 }",
    "body": "made of elements; thickness = 1 mm",
    "more": "tool floor { kind is plane; point = (0, 0, 0.01) mm; normal = (0, 0, 1) }",
    "around": "contact is tools only",
}  # fmt: skip
APART = SHEET | {"more": "", "around": "contact is off"}
WALL = {"mesh": BALL, "body": "made of elements; thickness = 1 mm"}
FILLED = {
    "mesh": 'imported { file "meshes/liver.obj" in mm; filling is tetrahedra; cell = 20 mm }'
}
BRANCH = "relaxing share = 30 %; relaxation time = 1 s"
THREE = BRANCH + "".join(
    f"; {which} relaxing share = 20 %; {which} relaxation time = {time}"
    for which, time in (("second", "10 s"), ("third", "100 s"))
)
FLOW = "yield stress = 1 Pa; flow viscosity = 1 MPa*s"
VISCOUS = "retardation time = 1 ms"


class Feature(Struct, frozen=True):
    """Something that a scene may have.

    Attributes:
        name: As the table shows it.
        kind: Of the blocks whose items are counted.
        entries: Of ``SCENE``.
        besides: Entries of the scene without it, whose time is subtracted; None for none.
    """

    name: str
    kind: str
    entries: dict[str, str]
    besides: dict[str, str] | None = None


SOLID = {"mesh": BLOCK}
FEATURES = (
    Feature("hexahedron", "elements", SOLID),
    Feature("hexahedron: viscosity", "elements", SOLID | {"matter": VISCOUS}, SOLID),
    Feature("hexahedron: one branch", "elements", SOLID | {"matter": BRANCH}, SOLID),
    Feature("hexahedron: three branches", "elements", SOLID | {"matter": THREE}, SOLID),
    Feature("hexahedron: yield", "elements", SOLID | {"matter": FLOW}, SOLID),
    Feature("tetrahedron with ten nodes", "elements", FILLED),
    Feature("triangle of a wall, with bending", "membranes", WALL),
    Feature("triangle: viscosity", "membranes", WALL | {"matter": VISCOUS}, WALL),
    Feature("triangle: one branch", "membranes", WALL | {"matter": BRANCH}, WALL),
    Feature("triangle: pressure", "membranes",
            WALL | {"more": "script { at 0 s: press piece with 1 Pa }"}, WALL),
    Feature("triangle: contact of faces with a floor", "membranes", SHEET, APART),
    Feature("the same with friction", "membranes",
            SHEET | {"around": f"{SHEET['around']}; friction = 0.3"}, APART),
    Feature("triangle: contact of its nodes with a floor", "membranes",
            SHEET | {"around": f"{SHEET['around']}; contact places is nodes"}, APART),
    Feature("triangle: kept volume", "membranes",
            WALL | {"more": "script { at 0 s: preserve volume of piece with 1 kPa }"}, WALL),
)  # fmt: skip


def compiled_scene(entries: dict[str, str]) -> Compiled:
    """Return a scene, compiled; entries are those of ``SCENE``."""
    none = {"poisson": "0.3", "matter": "", "body": "", "around": "", "more": ""}
    text = SCENE.format(**none | entries)
    return compile_request(Request(Source("scene.tis", text)))[0]


class Timed:
    """A scene whose evaluations of forces are timed again and again.

    Args:
        steps: Of each measurement; None for as many as take ``LASTS``.
    """

    def __init__(self, compiled: Compiled, steps: int | None = None):
        self.state = state_at_start(compiled)
        asked = Method("velocity verlet", None, STEP, 1.0)
        self._engine = Engine(
            self.state.network, asked, np.zeros(0), lambda samples: None, backend="compiled"
        )
        self._steps = steps or 10
        self._until = self._steps * STEP
        self._engine.advance(self.state, self._until)
        if steps is None:
            self._steps = max(STEPS, int(LASTS / self.seconds()))

    def seconds(self) -> float:
        """Return the processor time of an evaluation [s]."""
        before = self._engine.statistics.evaluations
        self._until += self._steps * STEP
        begun = time.process_time()
        self._engine.advance(self.state, self._until)
        took = time.process_time() - begun
        return took / (self._engine.statistics.evaluations - before)

    def items(self, kind: str) -> int:
        """Return the number of items of the blocks of a kind."""
        found = sum(b.field.item_count for b in self.state.present_blocks if b.kind == kind)
        assert found, f"there are no {kind}"
        return int(found)


def costs() -> str:
    """Return the table of forces."""
    spring = Timed(build(nets()[0]))
    springs = spring.state.network.spring_count
    rows = [("spring", "1", f"{1e9 * spring.seconds() / springs:.1f} ns")]
    for feature in FEATURES:
        whole = Timed(compiled_scene(feature.entries))
        plain = None if feature.besides is None else Timed(compiled_scene(feature.besides))
        count, ratios, times = whole.items(feature.kind), list[float](), list[float]()
        for _ in range(REPEATS):
            one = whole.seconds() - (0.0 if plain is None else plain.seconds())
            times.append(one / count)
            ratios.append(one / count / (spring.seconds() / springs))
        rows.append((feature.name, f"{median(ratios):.0f}", f"{1e9 * median(times):.0f} ns"))
        tell(" ".join(rows[-1]))
    return table(("item", "springs", "time"), rows)


#: Scenes whose matrices are made: names and entries.
MATRICES = {
    "block of 64 hexahedra": {"mesh": BLOCK.replace("24", "8"), "matter": VISCOUS},
    "block of 512 hexahedra": {"mesh": BLOCK.replace("24", "16"), "matter": VISCOUS},
    "the same with a branch": {
        "mesh": BLOCK.replace("24", "16"), "matter": f"{VISCOUS}; {BRANCH}"},
    "ball of 320 triangles": {"mesh": BALL.replace("= 3 }", "= 2 }"), "body": WALL["body"],
                              "matter": VISCOUS},
}  # fmt: skip


def matrices() -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table of implicit steps."""
    for name, entries in MATRICES.items():
        compiled = compiled_scene(entries)
        timed, state = Timed(compiled), state_at_start(compiled)
        inputs = KernelInputs(state.network, watched=False, ledger=False)
        inputs.update(state)
        solver, stage = inputs.solver(), inputs.stage
        assert stage is not None
        net = inputs.net(INTEGRATORS["trbdf2"])
        x, v = inputs.inwards(state.position), inputs.inwards(state.velocity)
        made, solved = list[float](), list[float]()
        for k in range(REPEATS):
            one, begun = timed.seconds(), time.process_time()
            # Another step size each time, since S of the last one is kept.
            assert stage.assemble(1e-3 * (1.0 + 0.01 * k), x, v, net, solver)
            made.append((time.process_time() - begun) / one)
            begun = time.process_time()
            stage.solve(np.ones_like(x), net, solver)
            solved.append((time.process_time() - begun) / one)
        unknowns = 3 * int(np.count_nonzero(~state.held))
        yield name, f"{unknowns}", f"{median(made):.0f}", f"{median(solved):.1f}"
        tell(f"{name}: {median(made):.0f} {median(solved):.1f}")


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure forces, and matrices of implicit steps."""
    implicit = table(("scene", "unknowns", "matrix and factor", "solution"), list(matrices()))
    publish("force_costs", {"forces": costs(), "implicit": implicit}, write=write)


if __name__ == "__main__":
    main()
