"""Other solvers that can solve a scene, and why some cannot."""

from collections.abc import Iterable
from importlib.util import find_spec

from benchmarks.rivals import by_cvode, by_mujoco, by_scipy
from benchmarks.rivals.scales import MotionScales
from tissuec.analysis.bench import Rivals
from tissuec.analysis.bench_solvers import BenchProblem, BenchSolver
from tissuec.model.network import Floats

JUDGES = ("DOP853", "Radau")  # of SciPy, for a second opinion

SURPRISES = (
    "other solvers are omitted: they need the times of all events, but this scene has "
    "ruptures or conditions, whose times are not known in advance"
)

MEMORY = (
    "other solvers are omitted: their state consists of positions and velocities only, but "
    "in this scene springs or friction have additional state"
)


CONTACT = "other solvers are omitted: they do not support contact"


def solvers_of(problem: BenchProblem, position: Floats) -> tuple[list[BenchSolver], list[str]]:
    """Return the other solvers that can solve a problem, and sentences about those left out.

    Args:
        problem: The scene of the bench.
        position: A solution, for the scales of the motion [m], shape (row, node, 3).
    """
    if obstacle := _obstacle(problem):
        return [], [obstacle]
    if problem.network.contact is not None:
        return [], [CONTACT]
    scales = MotionScales.of(problem, position)
    offers = (_by_scipy(problem, scales), _by_cvode(problem, scales), _by_mujoco(problem))
    solvers = [solver for found, _ in offers for solver in found]
    return solvers, [why for _, why in offers if why]


def judges_of(problem: BenchProblem, position: Floats) -> list[BenchSolver]:
    """Return the solvers that can give a second opinion on a solution; see ``solvers_of``."""
    if _obstacle(problem):
        return []
    scales = MotionScales.of(problem, position)
    return [by_scipy.SciPySolver(problem, method, scales) for method in JUDGES]


def _obstacle(problem: BenchProblem) -> str:
    """Return why no other solver can follow the motion of a scene; empty if they can."""
    if problem.plan.breakable or problem.plan.triggers:
        return SURPRISES
    return MEMORY if problem.network.internal else ""


RIVALS = Rivals(solvers_of, judges_of)

Offer = tuple[list[BenchSolver], str]


def _by_scipy(problem: BenchProblem, scales: MotionScales) -> Offer:
    coordinates = 3 * problem.network.node_count
    methods: Iterable[str] = (*by_scipy.EXPLICIT, *by_scipy.IMPLICIT)
    why = ""
    if coordinates > by_scipy.LARGEST:
        methods = by_scipy.EXPLICIT
        why = (
            f"SciPy's {', '.join(by_scipy.IMPLICIT)} are omitted: they would need a matrix of "
            f"{2 * coordinates} x {2 * coordinates} numbers, sparse or in a band"
        )
    return [by_scipy.SciPySolver(problem, method, scales) for method in methods], why


def _by_cvode(problem: BenchProblem, scales: MotionScales) -> Offer:
    if find_spec("sksundae") is None:
        return [], _missing("CVODE", "scikit-sundae")
    methods = by_cvode.METHODS
    return [by_cvode.CvodeSolver(problem, method, scales) for method in methods], ""


def _by_mujoco(problem: BenchProblem) -> Offer:
    if find_spec("mujoco") is None:
        return [], _missing("MuJoCo", "mujoco")
    if why := by_mujoco.refusal(problem):
        return [], f"MuJoCo is omitted: {why}"
    integrators = by_mujoco.INTEGRATORS
    return [by_mujoco.MujocoSolver(problem, name) for name in integrators], ""


def _missing(name: str, package: str) -> str:
    return (
        f"{name} is omitted: {package} is not installed; "
        'install it: pip install "tissuec[bench]"'
    )
