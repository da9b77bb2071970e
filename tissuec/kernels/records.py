"""Records of the stepping code; ``compiled.record_tables`` places them in memory.

Vectors of all nodes are flat, shape (3 node,): x0 y0 z0 x1 …, so that kernels index scalars.
Held nodes are part of them and keep still because their inverse mass is zero.
"""

from typing import Annotated, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
# Compiled code knows the number of axes of each array: one, unless the type says another.
Rows = Annotated[Floats, 2]
Stack = Annotated[Floats, 3]
Pixels = Annotated[NDArray[np.float32], 3]
IntegerRows = Annotated[Integers, 2]
Pairs = Annotated[NDArray[np.int32], 2]


class Team(NamedTuple):
    """Threads that share loops, and room for what each finds; see ``engine.threads``."""

    threads: int  # the one of the loop over steps included
    words: Integers  # by which they give each other orders, shape (32 + 8 part,)
    found: Rows  # largest values in parts of a loop, two of each, shape (2, part)
    each: Rows  # scratch for springs, see ``springs.pairs_kernel``, shape (part, ROOM)
    work: Floats  # powers by pieces of nodes [W], shape (piece,)
    lost: Floats  # powers by pieces of nodes or springs [W], shape (piece,)
    near: Integers  # 1 where springs are near to breaking, shape (piece,)


class BoundaryConditions(NamedTuple):
    """Prescribed motions and time-dependent loads as tables of numbers.

    Motions and loads share the layout: act ``i`` concerns ``nodes[first[i]:first[i + 1]]`` and
    adds the terms from ``term_first[i]`` to ``term_first[i + 1]``. Motions come first.
    """

    motions: int  # acts below this number are motions, the others loads
    first: Integers  # shape (act + 1,)
    nodes: Integers  # shape (entry,)
    base: Rows  # positions that the motions start from [m], shape (entry, 3)
    partial: Integers  # 1 for motions in some directions, shape (act,)
    along: Rows  # changes by what is missing there, row by row; (entry, 9), or (0, 9) for none
    share: Floats  # factors of loads, shape (entry,)
    term_first: Integers  # shape (act + 1,)
    term_vector: Rows  # [m] or [N], shape (term, 3)
    term_curve: Integers  # shape (term,)
    turn_curve: Integers  # of the rotation, -1 without one, shape (act,)
    turn_centre: Rows  # [m], shape (act, 3)
    turn_axis: Rows  # unit vectors, shape (act, 3)
    turn_angle: Floats  # [rad], shape (act,)
    origin: Floats  # time from which a curve counts [s], shape (curve,)
    power: Rows  # coefficients, shape (curve, power)
    amplitude: Floats  # of the sine, shape (curve,)
    angular: Floats  # its angular frequency [1/s], zero without a sine, shape (curve,)


class RestLengthActuators(NamedTuple):
    """Springs whose rest lengths change: base + change times a profile."""

    spring: Integers  # places among the springs, shape (reel,)
    low: Integers  # nodes, shape (reel,)
    high: Integers
    base: Floats  # [m], shape (reel,)
    change: Floats  # [m], shape (reel,)
    act: Integers  # whose first component is the profile, shape (reel,)


class EmbeddingTable(NamedTuple):
    """Embedded nodes and their hosts; see ``forces.acting.embedding``."""

    nodes: Integers  # shape (n,)
    first: Integers  # hosts of node k are hosts[first[k]:first[k + 1]], shape (n + 1,)
    hosts: Integers  # shape (host,)
    weights: Floats  # shape (host,)


class GuideTable(NamedTuple):
    """Nodes that are free in some directions; see ``model.guides``."""

    nodes: Integers  # shape (n,)
    within: Rows  # projections into the free directions, row by row, shape (n, 9)


class ContactTable(NamedTuple):
    """Shapes and the nodes that they can touch; see ``forces.contact``."""

    nodes: Integers  # shape (m,)
    first: Integers  # shapes near node k are shape[first[k]:first[k + 1]], shape (m + 1,)
    shape: Integers  # numbers of shapes, shape (pair,)
    weight: Floats  # how often they count, shape (pair,)
    radius: Floats  # [m], shape (pair,)
    kind: Integers  # shape (shape,)
    points: IntegerRows  # nodes that carry each shape, shape (shape, 3)
    surface: Integers  # that each shape belongs to, shape (shape,)
    starts: Integers  # nodes of part p are starts[p] … starts[p + 1], shape (part + 1,)
    stops: Integers  # scratch, where the rows of each part end, shape (part,)
    part: int  # that is computed, their number to add them up, -1 to do all at once
    met: Rows  # scratch, for the pairs that touch, shape (pair, 31)
    at: IntegerRows  # places of their nodes and three points among coordinates, and the pair
    memory: Integers  # rows of velocities that are bristles, shape (m,) or (0,)
    # Scratch, their rates [m/s²], shape (m, 3) or (0, 3); if bristles are cut, with further
    # columns, see ``contact.bristle_kernel``.
    bent: Rows
    # Time for which an implicit stage solves for them [s], 0 where they are given, shape (1,)
    lag: Floats
    bends: Integers  # of the law that are passed: at the last look, least and most in a step
    listed: Floats  # positions at which pairs were listed [m], shape (3 node,)
    squares: Floats  # scratch, shape (node,)
    reach: float  # longest way of a node since pairs were listed [m]
    stiffness: Floats  # [N/m], shape (m,)
    layer: float  # [m]
    damping: float  # [s/m]
    friction: float  # coefficient everywhere, or -1 where it is that of tissues
    rate: float  # [1/s]


class Roughness(NamedTuple):
    """Coefficients of friction that tissues give; see ``forces.contact``."""

    node: Floats  # shape (m,)
    face: Rows  # of the points that carry each shape, shape (shape, 3)


class ContactRecord(NamedTuple):
    """Contact; if there are points between nodes, these follow the nodes in its arrays."""

    touches: ContactTable
    rough: Roughness
    # Kind of the surface, see ``contact.sides_kernel``, of pairs whose triangle
    # determines the side of a point, else 0, shape (pair,) or (0,)
    sided: Integers
    alike: float  # distances of these are equal below it [m]
    at: Integers  # where the coordinates of each point begin, shape (near,)
    corners: IntegerRows  # the same of its corners, shape (near, 3)
    shares: Rows  # N_a, shape (near, 3)
    x: Floats  # scratch, positions of nodes and points [m], shape (3 (node + point),)
    v: Floats  # scratch, their velocities [m/s], shape as ``x``
    f: Floats  # scratch, forces on them [N], shape as ``x``


class InternalVariables(NamedTuple):
    """Internal variables of springs, first of branches; see ``forces.springs``."""

    first: Integers  # branches of spring s are first[s]:first[s + 1], shape (spring + 1,)
    constant: Floats  # c1 [N/m], shape (branch,)
    pace: Floats  # 1 / τ [1/s], shape (branch,)
    flow: Integers  # variable of the rest length of each spring, -1 without, shape (spring,)
    limit: Floats  # F [N], shape (spring,)
    viscosity: Floats  # η [N s/m], shape (spring,)
    slot: Integers  # where variables are among velocities, shape (variable,)
    rate: Floats  # of variables in these [1/s], shape (variable,)
    scale: Floats  # its reciprocal [s], shape (variable,)
    change: Floats  # scratch, rates of those velocities [m/s²], shape (variable,)
    rows: Integers  # of velocities that the variables are, shape (m,)


class Runs(NamedTuple):
    """Springs in runs between nodes (i, i + k), (i + 1, i + 1 + k), …; see
    ``engine.spring_runs``.

    Gaps and dead springs have a negative length at rest. Stiffness, damping and limits are
    shape (spring,), or (tile,) where all springs share them; (0,) where none has them.
    """

    low: Integers  # place of node i in the tiles of two blocks, shape (run,)
    high: Integers  # place of node i + k there, shape (run,)
    length: Integers  # springs, shape (run,)
    at: Integers  # place of the first among the springs, shape (run,)
    block: Integers  # runs of block b are block[b]:block[b + 1], shape (block + 1,)
    group: Integers  # blocks of group g are group[g]:group[g + 1], shape (group + 1,)
    width: int  # nodes of a block
    stiffness: Floats  # [N/m]
    damping: Floats  # [N s/m]
    rest: Floats  # [m], shape (spring,), or (0,) where the next two give them
    # Bits of a length, and how many numbers of this precision further that of each spring is;
    # ``springs.runs_kernel.NO_STEP`` of what is none
    base: Integers  # shape (run,) or (0,)
    steps: NDArray[np.int16]  # shape (spring,) or (0,)
    near: Floats  # tension from which a closer look is needed [N]
    near_crush: Floats  # the same of pressure
    alike: bool  # springs share stiffness, damping and limits
    tiles: Floats  # scratch: components of vectors, see ``springs.runs_kernel``
    ring: int  # numbers of ``tiles`` for each part of a loop
    halos: Floats  # scratch: forces on the block after each group but the last, flat


class Chunks(NamedTuple):
    """Nodes in chunks, whose springs threads take at a time; see ``engine.threads``."""

    node: Integers  # nodes of chunk c are node[c]:node[c + 1], shape (chunk + 1,)
    low: NDArray[np.uint32]  # four times the lower nodes of springs, shape (spring,)
    high: NDArray[np.uint32]  # four times the upper nodes, shape (spring,)
    to: NDArray[np.uint32]  # where springs add what they do to upper nodes, shape (spring,)
    states: Floats  # scratch: positions, then velocities, four numbers a node, (8 node,)
    sums: Floats  # scratch: of the chunk's own nodes, then of others, shape (4 (node + slot),)
    slot: Integers  # slots of chunk c are slot[c]:slot[c + 1], shape (chunk + 1,)
    first: NDArray[np.uint32]  # those of node i are of[first[i]:first[i + 1]], (node + 1,)
    of: NDArray[np.uint32]  # four times slots by nodes and then by chunks, shape (slot,)


class Fields(NamedTuple):
    """Fields that act on nodes, in parts: compiled functions, and their tables.

    Parts of one group have no node in common; see ``engine.threads``.
    """

    first: Integers  # parts of group g are first[g]:first[g + 1], shape (group + 1,)
    address: Integers  # of the functions, shape (part,)
    table: Integers  # addresses of their tables, shape (part,)
    power: Rows  # scratch: supplied and dissipated by each [W], shape (part, 2)
    kept: object = ()  # what both are in, for Python only


class Operations(NamedTuple):
    """Addresses of compiled operations on a net, 0 for those that nothing calls."""

    assemble: int = 0
    bend_of_passed: int = 0
    brake: int = 0
    brake_by_e: int = 0
    brake_side: int = 0
    brake_slope: int = 0
    find_sides: int = 0
    force: int = 0
    greatest_force: int = 0
    greatest_inner_force: int = 0
    kinetic: int = 0
    peaks: int = 0
    place: int = 0
    pull: int = 0
    side: int = 0
    slack: int = 0
    slope: int = 0
    solve: int = 0
    springs: int = 0
    tension: int = 0


class Net(NamedTuple):
    """Everything that acts on the nodes; springs sorted by their lower node.

    What a scene has nothing of is None, from the reels on.
    """

    first: NDArray[np.uint64]  # springs of node i are first[i]:first[i + 1], (node + 1,)
    other: NDArray[np.uint32]  # three times their upper node, shape (spring,)
    stiffness: Floats  # c [N/m], shape (spring,)
    damping: Floats  # d [N s/m], shape (spring,)
    rest: Floats  # L0 [m], shape (spring,)
    strength: Floats  # [N], shape (spring,)
    crush: Floats  # [N], shape (spring,)
    law: NDArray[np.int32]  # of each spring, 0 if linear, shape (spring,)
    near: Floats  # tension from which a closer look is needed [N], shape (spring,)
    near_crush: Floats  # the same of pressure
    inverse_mass: Floats  # [1/kg], zero for held nodes, shape (node,)
    # By which forces become accelerations: the same, and 1 for variables of fields [1/kg]
    response: Floats
    internal_rows: Integers  # rows of velocities that are variables of fields, shape (m,)
    steady: Floats  # gravity and constant loads by mass [m/s²], zero if held, (3 node,)
    push: Floats  # constant loads on free nodes [N], shape (3 node,)
    driven: Integers  # nodes on prescribed paths
    drag: Floats  # ambient damping [N s/m], shape (node,)
    pushed: bool  # some of ``steady`` is not zero
    dragged: bool  # some of ``drag`` is not
    watched: bool  # springs may break
    crushed: bool  # and do so under pressure, too
    ledger: bool  # work and dissipation are integrated
    reeled: bool  # there are threads that are drawn in or paid out
    touched: bool  # there are instruments or threads that touch
    inelastic: bool  # some springs relax or flow
    cornered: bool  # some laws have corners
    embedded: bool  # there are embedded nodes
    guided: bool  # some nodes are held in some directions
    acts: BoundaryConditions
    reels: RestLengthActuators
    touches: ContactTable
    internal: InternalVariables
    embedding: EmbeddingTable
    guides: GuideTable
    runs: Runs
    chunks: Chunks
    fields: Fields
    team: Team
    operations: Operations = Operations()


class Solver(NamedTuple):
    """The matrix S = M + q (D + drag) + q² K of an implicit step, q = h γ, ready to solve.

    Of springs alone, banded: its Cholesky factor in rows of the lower band, as LAPACK keeps
    them. Otherwise the terms to multiply by it and the inverses of its diagonal blocks. Numbers
    of ``slot`` are places of free nodes in an order of narrow band. With anything else,
    ``engine.stage_matrix`` holds the matrix, and the arrays for those are empty.
    """

    slot: Integers  # of each node, -1 if held, shape (node,)
    band: Rows  # shape (3 free, width + 1), or (0, 0) where solving iterates
    bar: Rows  # along, across [kg] and direction of each spring, shape (spring, 5) or (0, 5)
    block: Rows  # inverses of the diagonal blocks [1/kg], shape (node, 6) or (0, 6)
    unknown: Floats  # right-hand side and solution, shape (3 free,)
    scratch: Rows  # shape (4, 3 node) or (0, 0)
    at: Floats  # positions that S was made at [m], shape (3 node,)
    speed: Floats  # velocities that S was made at [m/s], shape (3 node,)
    # q of S [s], 0 without one; worst contraction of the step; 1 if S is to be made again; the
    # time that it was made at [s]; 1 if errors of velocities are multiplied by S⁻¹ M
    made: Floats  # shape (5,)


class Tableau(NamedTuple):
    """Coefficients of a Runge-Kutta or Runge-Kutta-Nyström method for x'' = a(x, v).

    Stage i is at x + c_i h v + h² Σ X_ij a_j with the velocity v + h Σ V_ij a_j, where a_j is
    the acceleration of stage j; with its own one among them it is implicit. One stage is the
    result of the step. Columns are those of ``Work.rows``: c, which belongs to v / h, and then
    the stages.
    """

    for_x: Rows  # c and X, shape (stage, 1 + stage)
    for_v: Rows  # 0 and V
    error_x: Rows  # of two estimates of the error, or one and zeros, shape (2, 1 + stage)
    error_v: Rows
    result: int  # number of the stage that is the result
    carries: bool  # the stage before it is the first one of the next step


class Work(NamedTuple):
    """State and scratch of one run; halves 0 and 1 hold a step's start and end in turn."""

    x: Rows  # positions [m], shape (2, 3 node)
    v: Rows  # velocities [m/s], shape (2, 3 node)
    a: Rows  # accelerations [m/s²], shape (2, 3 node)
    ledger: Rows  # work and dissipated energy so far [J], shape (2, 2)
    origin: Floats  # positions at the start of the run [m], shape (3 node,)
    drift: Floats  # common velocity of each body, lately [m/s], shape (3 node,)
    # Accelerations of the stages [m/s²], from row 2 on, as ``kernels.stages`` combines them,
    # and scratch of methods, shape (row, 3 node)
    rows: Rows
    end_row: int  # of the acceleration at the end of the step
    power: Rows  # of work and of dissipation at the stages [W], shape (row, 2)
    trial_x: Floats  # shape (3 node,)
    trial_v: Floats  # shape (3 node,)
    trial_ledger: Floats  # shape (2,)
    zero: Floats  # shape (3 node,)
    each: Floats  # scratch of measures of errors, which leave out tools, shape (node,)
    moving: Floats  # scratch of measures of motion, which leave out internal variables as well
    tableau: Tableau  # coefficients of the method, None if it has none
    choices: Floats  # what can be chosen of a procedure, shape (choice,)
    dense_x: Rows  # positions within the step: powers of its part, shape (power, row)
    dense_v: Rows  # the same for velocities
    # Positions by a polynomial of lower order minus those, (0, row) if there is none
    embedded_x: Rows
    embedded_v: Rows  # the same for velocities, its derivative
    weights: Rows  # shape (2, row)
    tension: Rows  # three samples of the springs [N], shape (3, spring) or (3, 0)
    booked: Rows  # two estimates of the error of the ledger [J], shape (2, 2)
    trend: Floats  # rates of both powers in the last step [W/s], NaN if unknown, shape (2,)
    # Evaluations, factorisations, solutions and stalls of steps so far, and evaluations for
    # looks inside of steps, shape (5,)
    effort: Integers
    # Of the step, in which its work and dissipation are found; 0: by its stages, shape (1,)
    pieces: Integers
    inner: Rows  # scratch of that: x, v and a within the step, shape (3, 3 node)
    sides: Stack  # of corners of laws at two looks, shape (2, 3, spring) or (2, 3, 0)
    doubt: Floats  # what work and dissipation may be wrong by so far [J], shape (1,)
    errors: Floats  # estimates, of positions [m] and of velocities [m/s], shape (2,)
    goal: Floats  # errors that solving may leave in positions [m], velocities, shape (2,)
    # Largest rate of the motion, or one over the next time step of a method [1/s],
    # where it wants one, shape (1,)
    rate: Floats
    solver: Solver
    team: Team


class Task(NamedTuple):
    """The task of one call of the stepping code."""

    until: float  # land here [s]
    evaluations: int  # come back at the first step's start with so many in all
    # Come back after so many accepted steps, before the samples of the last one are taken, with
    # states within them; 0: do not. After more, if only some of several steps have such states.
    hold: int
    spacing: float  # at which steps have such states, if several are made at once [s]
    viewed: float  # come back likewise with the step that ends here or later [s]
    fixed: int  # 1: keep the size of the steps
    longest: float  # step that still follows the prescribed paths, unless fixed [s]
    budget: float  # local error allowed per second, relative to the motion [1/s]
    growth: float  # further, by as much as the largest displacement grows, relative to that
    share: float  # local error allowed in one step, relative to the motion
    latitude: float  # how many times as much is allowed in the last step
    amplification: float  # logarithm by which it is less in each step before
    duration: float  # of the run [s]
    rubs: int  # 1: errors of bristles count as velocities where contacts change
    inside: float  # error allowed of samples within steps, relative to the motion
    jolt: float  # change of speeds allowed where a spring turns over, relative to the motion
    floor: float  # smallest displacement that errors are measured by [m]
    noise: float  # error that is put down to rounding [m]
    least: float  # smallest energy that errors of the ledger are measured by [J]
    bound: float  # displacement beyond which the run is examined [m]
    stride: float  # longest way of a node, lest it passes through a shape unseen [m]


class Progress(Struct):
    """Progress of a run; with the arrays of ``Work`` all that a resumed run needs.

    The loop over steps changes it in place.
    """

    time: float  # of the state [s]
    step: float  # size of the next step [s]
    end: float  # of the step under way [s]
    memory: float  # error ratio of the last accepted step
    wait: int  # steps of the present size that come before it may grow
    displacement: float  # largest so far [m]
    displacement_before: float  # the same before the step under way [m]
    speed: float  # largest so far [m/s]
    speed_before: float  # the same before the step under way [m/s]
    speed_now: float  # largest beside ``Work.drift`` at the end of the last step [m/s]
    # That nodes may move beside ``Work.drift`` before who follows the motion sees it again [m]
    leeway: float
    current: int  # half of Work that holds the state
    pending: int  # 1: a step is accepted, its samples are not all taken
    prepared: int  # 1: the step under way can be evaluated inside
    fresh: int  # 1: accelerations are not known yet
    accepted: int
    rejected: int
    sample: int  # next sample
    filled: int  # samples in the buffer
    smallest: float  # step so far [s]
    largest: float  # step so far [s]
    energy: float  # largest so far, where the ledger is kept [J]
    error: float  # of positions, local estimates summed up [m]
    room: float  # that nodes may move before any spring can have turned over [m]
    # Step before it was made smaller because a spring turns over, minus that if it was to land
    # on a corner of a law, or 0 [s]
    usual: float
    bends: int  # of the laws of contact that are passed
    glanced: int  # states within steps in the buffer


class Trial(NamedTuple):
    """A step that was tried."""

    verdict: int  # whether it is accepted or rejected, or why the stepping code comes back
    near: bool  # whether a spring is near its strength
    ratio: float  # of its error to the allowed one
    error: float  # of positions, as estimated [m]
    reach: float  # largest displacement until its end [m]
    pace: float  # largest speed until its end [m/s]


class Buffer(NamedTuple):
    """A batch of samples under way."""

    times: Floats  # of all samples of the run [s], shape (sample of the run,)
    time: Floats  # shape (sample,)
    position: Rows  # shape (sample, 3 node)
    velocity: Rows  # shape (sample, 3 node)
    ledger: Rows  # shape (sample, 2)
    error: Floats  # of positions, as estimated [m], shape (sample,)
    reach: Floats  # largest displacement of a node before [m], shape (sample,)
    doubtful: Integers  # what ``engine.step_refined`` doubts of it, shape (sample,)
    # States within steps, for conditions; none where nothing is waited for.
    glance_time: Floats  # [s], shape (glance,)
    glance_position: Rows  # [m], shape (glance, 3 node)
    glance_velocity: Rows  # [m/s], shape (glance, 3 node)


GLANCES = 4  # states of each step, at equal distances, the last at its end
LOOKED = 4  # place in ``Work.effort`` of evaluations for looks inside of steps
# Why the stepping code came back.
REACHED, PAUSED, HELD, FULL, SURPASSED, UNDERFLOW, OUTSIZE, UNSOLVED, STRAYED = range(9)
VIEWED, ROAMED = 9, 10
