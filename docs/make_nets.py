"""Learn nets of springs from exact models of organs, for the tables of ``learning.md``.

    python -m docs.make_nets

takes some minutes, in the folder of the repository. Times are those of the processor.
"""

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from time import process_time

from msgspec import Struct

import tissuec
from tissuec.core.markdown import replace_places
from tissuec.learn.fit.learning import learn
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

HERE = Path(__file__).resolve().parent
PAGE, EXAMPLES = HERE / "learning.md", HERE / "examples" / "learning"
REPEATS = 3  # of runs whose time is taken: the shortest counts
Params = Mapping[str, str | float]


class Organ(Struct, frozen=True):
    """An exact model, the net that is learnt from it, and its sizes.

    Attributes:
        exact: Name of the scene of the exact model.
        held_out: Name of its second result, and the params of that run.
        net: Name of the scene of the net.
        sizes: Params of nets of several sizes.
    """

    exact: str
    held_out: tuple[str, Params]
    net: str
    sizes: tuple[Params, ...]


ORGANS = {
    "block": Organ(
        "exact_block",
        ("pressed_block", {"stretch": "-6 mm"}),
        "block_net",
        tuple({"fineness": size} for size in ("20 mm", "10 mm", "6.666666667 mm")),
    ),
    "tube": Organ(
        "exact_tube",
        ("lifted_tube", {"stretch": "0 mm", "lift": "12 mm"}),
        "tube_net",
        tuple(
            {"rings": rings, "sides": sides}
            for rings, sides in (("8", "6"), ("12", "8"), ("16", "10"))
        ),
    ),
}


def main() -> None:
    """Learn all nets; rewrite the tables of the page."""
    tables = {name: table(organ) for name, organ in ORGANS.items()}
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(replace_places(page, tables, mark="net"), encoding="utf-8")


def table(organ: Organ) -> str:
    """Return the rows of the exact model and of its nets."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        for path in EXAMPLES.glob("*.tis"):
            shutil.copy(path, here)
        name, params = organ.held_out
        scene = here / f"{organ.exact}.tis"
        tissuec.run(scene, out=here / f"{organ.exact}.vtkhdf", companion="off")
        tissuec.run(scene, out=here / f"{name}.vtkhdf", params=dict(params), companion="off")
        compiled, _ = compile_request(Request.file(scene))
        rows = [
            "| model | nodes | spring constant | viscosity | mass of a node | error | "
            "held out | fit | run |",
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
            f"| elements | {len(compiled.network.position)} | | | | | | | "
            f"{fastest(scene, {}):.2g} s |",
        ]
        rows += [net_row(here / f"{organ.net}.tis", size) for size in organ.sizes]
    return "\n".join(rows)


def net_row(path: Path, size: Params) -> str:
    """Learn a net of a size, and run it with what was learnt."""
    request = Request.file(path, overrides=[f"{name}={text}" for name, text in size.items()])
    compiled, _ = compile_request(request)
    began = process_time()
    learnt = learn(compiled, compiled.fit_problems[0], request)
    took = process_time() - began
    constant, viscosity, mass = (float(one.value[0]) for one in learnt.estimates)
    found = {"constant": constant, "damping": viscosity, "weight": mass}
    fitted, held_out = learnt.fitted
    seconds = fastest(path, {**size, **found})
    return (
        f"| net | {len(compiled.network.position)} | {constant:.3g} N/m | "
        f"{1e3 * viscosity:.3g} mN·s/m | {1e3 * mass:.3g} g | {100 * fitted.error:.1f} % | "
        f"{100 * held_out.error:.0f} % | {took:.0f} s | {seconds:.2g} s |"
    )


def fastest(path: Path, params: Params) -> float:
    """Return the time of a run [s]."""
    times = []
    for _ in range(REPEATS):
        began = process_time()
        tissuec.run(path, params=dict(params), companion="off")
        times.append(process_time() - began)
    return min(times)


if __name__ == "__main__":
    main()
