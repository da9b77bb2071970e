"""Integrators: one file each, which states its order and its field of use.

The stepping code of a member is plain functions over the operations of ``tissuec.kernels``.
They run slowly as Python; the engine binds the same functions to compiled operations.

Shared arguments:
    time, end: Start and end of the step [s].
    h: Size of the step [s].
    current: Half of ``work`` that contains the start of the step, 0 or 1; the end is in the
        other.
    work: State and scratch of the run; its fields give the shapes and units.
    net: What acts on the nodes; its fields give the shapes and units.
    stage: Index of the stage.
    x: Positions of all nodes [m], flat, shape (3 node,).
    v: Velocities of all nodes [m/s], flat, shape (3 node,).
    a: Accelerations of all nodes [m/s²], flat, shape (3 node,).
    ratio: Error of the step divided by the allowed error.
    memory: Such a ratio of an earlier step, as ``propose`` returned it.
    wait: Steps of the present size that come before it may grow.
    q: Step size times the coefficient γ of an implicit method [s].
    solver: Matrix of an implicit step; its fields give the shapes and units.
    vector: Residuals of accelerations [m/s²], shape (3 node,), replaced by the solution.
    part, parts: Index of this thread's share of the loop, and the number of shares.
"""

from typing import ClassVar, Protocol

from tissuec.core.registry import Family
from tissuec.kernels.records import Floats, Net, Tableau, Work


class Integrator(Protocol):
    """Interface of members of ``INTEGRATORS``; their docstrings give equation and source.

    Attributes:
        order: Of the error of positions and velocities against the step. A member whose order
            is less where forces depend on velocities declares that as ``order_with_dashpots``.
        symplectic: Whether the flow without viscosity keeps the symplectic form.
        implicit: Whether a step solves equations.
        conservative: Whether it is only for scenes without viscosity and drag.
        promises: Whether it estimates errors and so can keep a tolerance; one that does not
            needs a step, and a run with it books energies, to say what it adds to them.
        stabilised: Whether a step takes as many stages as the fastest rate requires.
        evaluations: Force evaluations of a step, about.
        rows: Number of rows of ``Work.rows``.
        end_row: The one that belongs to the end of the step; row 1 belongs to its start.
        control_order: Power of the step in the error per unit step.
        safety: Multiple of the tolerance that the sum of all error estimates may reach; above
            1 where estimates are known to be that much larger than errors. A member that may
            let more add up where dashpots make errors die away declares how many times as much
            as ``fading``.
        share: Part of the tolerance that the estimate of one step may reach.
        latitude: How many times as much it may reach in the last step, whose error cannot grow
            any more.
        amplification: Logarithm by which that is less for each step that is left: how much a
            motion is expected to amplify errors in a step at most, as chaotic motions of
            compressed springs without viscosity do.
        looks: Pieces in which a step is searched for ruptures.
        nearness: Part of its strength from which a spring is examined closely.
        tableau: Its coefficients; None for a method that is none of Runge-Kutta or Nyström.
        dense_x, dense_v, embedded_x: Coefficients within a step, as ``Work`` holds them.
    """

    order: ClassVar[int]
    symplectic: ClassVar[bool] = False
    implicit: ClassVar[bool] = False
    conservative: ClassVar[bool] = False
    promises: ClassVar[bool] = True
    stabilised: ClassVar[bool] = False
    evaluations: ClassVar[int]
    rows: ClassVar[int]
    end_row: ClassVar[int]
    control_order: ClassVar[float]
    safety: ClassVar[float]
    share: ClassVar[float]
    latitude: ClassVar[float] = 1.0
    amplification: ClassVar[float] = 0.0
    looks: ClassVar[int]
    nearness: ClassVar[float] = 0.9
    tableau: ClassVar[Tableau | None]
    dense_x: ClassVar[Floats]
    dense_v: ClassVar[Floats]
    embedded_x: ClassVar[Floats]

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return the largest stable step [s].

        Args:
            omega: Largest angular frequency of the network [1/s].
            zeta: Largest damping radius over twice ``omega``.
        """
        ...

    @staticmethod
    def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
        """Set the state at ``end``; return whether a spring is near its strength."""
        ...

    @staticmethod
    def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
        """Return the largest local errors in a node's position [m] and velocity [m/s].

        The third one is that of internal variables [m/s], such as bristles of friction.
        """
        ...

    @staticmethod
    def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
        """Set the ledger at the step's end; return its largest local error [J].

        Called after each accepted step, where work and dissipation are integrated.
        """
        ...

    @staticmethod
    def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
        """Complete an accepted step with accelerations; return the same as ``step``."""
        ...

    @staticmethod
    def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
        """Fill the rows that ``dense_x`` and ``dense_v`` combine."""
        ...

    @staticmethod
    def propose(h: float, ratio: float, memory: float, wait: int) -> tuple[float, float, int]:
        """Return size of the next step, memory and wait after an accepted step.

        Args:
            ratio: Its error over what is allowed.
            memory: Such ratio of an earlier step, as this function returned it.
        """
        ...


INTEGRATORS: Family[type[Integrator]] = Family("tissuec.engine.integrators", "integrator")
