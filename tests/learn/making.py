""" "Measured" data, made by the engine with a tolerance far below any noise."""

import numpy as np

from tissuec.compiler.compile import Compiled
from tissuec.core.structs import replace
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.model.network import Floats, Network
from tissuec.script.plan import Output


class Frames:
    """Takes frames as a result file would, and forgets everything else."""

    def __init__(self):
        self.times, self.positions = [], []

    def frames(self, time, position, velocity, fields):
        self.times.append(np.atleast_1d(time))
        self.positions.append(position)

    def __getattr__(self, name):
        return lambda *_, **__: None


def motion(
    compiled: Compiled, every: float, network: Network | None = None
) -> tuple[Floats, Floats]:
    """Return times [s] and positions [m] of all nodes, shape (time, node, 3)."""
    network = compiled.network if network is None else network
    nodes = np.arange(network.node_count)
    output = Output(nodes, every, False, (), np.inf)
    simulation = replace(
        compiled.plan.simulation, integrator="dop853", tolerance=1e-11, step=None
    )
    plan = replace(
        compiled.plan, output=output, expectations=(), simulation=simulation,
        needs_ledger=False,
    )  # fmt: skip
    found = Frames()
    outcome = run(network, plan, Recorder(network, plan, found))
    assert outcome.kind == "done", outcome.message
    return np.concatenate(found.times), np.concatenate(found.positions)


def write_positions(path, times, positions, ids, noise=0.0, seed=0, nodes=None):
    """Write a long table in millimetres; of all nodes, or of some."""
    random = np.random.default_rng(seed)
    noisy = positions + noise * random.standard_normal(positions.shape)
    chosen = range(positions.shape[1]) if nodes is None else nodes
    rows = ["t_s,node,x_mm,y_mm,z_mm"]
    for time, places in zip(times, 1e3 * noisy, strict=True):
        for node in chosen:
            x, y, z = places[node].tolist()
            rows.append(f"{time.item()!r},{ids[node]},{x!r},{y!r},{z!r}")
    path.write_text("\n".join(rows) + "\n")
