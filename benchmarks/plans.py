"""Times that plans foretell, over those that were measured, for scenes of the library.

A plan is that of `tissuec explain --plan`; measured is the processor time of `tissuec run`
without the companion run, in a process of its own, as the shortest of some runs. All scenes
take some minutes.
"""

import tempfile
from pathlib import Path

import click
from msgspec import Struct

from benchmarks.processes import seconds_of_run
from benchmarks.publishing import json_option, publish, tell
from tissuec.compiler.prediction import predict
from tissuec.core.markdown import table
from tissuec.core.resources import library
from tissuec.engine.run_cost import RunCost
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENES = library() / "scenes"


class Foretold(Struct):
    """The plan of a scene, and what its run took [s]."""

    scene: str
    cost: RunCost
    measured: float

    @property
    def ratio(self) -> float:
        """Return the time foretold over that measured."""
        return self.cost.seconds / self.measured


@click.command(help=__doc__)
@click.argument("scenes", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--repeats", default=2, show_default=True, help="Runs of each scene.")
@json_option
def main(scenes: tuple[Path, ...], repeats: int, as_json: bool) -> None:
    found: list[Foretold] = []
    for path in scenes or sorted(SCENES.glob("*.tis")):
        tell(path.name)
        compiled, _ = compile_request(Request.file(path))
        measured = min(_run(path) for _ in range(repeats))
        found.append(Foretold(path.stem, predict(compiled).cost, measured))
    heads = ("scene", *(f"{part} [s]" for part in RunCost._fields), "foretold [s]",
             "measured [s]", "ratio")  # fmt: skip
    rows = [
        (one.scene, *(f"{part:.2f}" for part in one.cost), f"{one.cost.seconds:.2f}",
         f"{one.measured:.2f}", f"{one.ratio:.2f}")
        for one in found
    ]  # fmt: skip
    document = [
        {"scene": one.scene, "measured": one.measured, "ratio": float(one.ratio)}
        | {"cost": {part: float(seconds) for part, seconds in one.cost._asdict().items()}}
        for one in found
    ]
    publish("plans", {"plans": table(heads, rows)}, document=document if as_json else None)


def _run(path: Path) -> float:
    """Return the processor time of a run [s]."""
    with tempfile.TemporaryDirectory() as folder:
        return seconds_of_run(path.resolve(), Path(folder, "run.vtkhdf"))


if __name__ == "__main__":
    main()
