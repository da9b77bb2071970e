"""What a feature of a scene costs, as a multiple of an evaluation with springs only.

Takes some minutes. Engines with and without the feature take turns, and medians of ratios are
shown.
"""

from statistics import median

import click
from msgspec import Struct

from benchmarks.publishing import publish, tell, write_option
from benchmarks.stepping import METHODS, REPEATS, Net, Stepping, build, nets
from tissuec.core.markdown import table


class Feature(Struct, frozen=True):
    """Something that a scene may have, as what is added to the text of the plain scene.

    Attributes:
        name: What it is called in the table.
        entries: Of ``scene``.
        script: Sentences that switch it on at 0 s.
        watched, ledger: What the engine is asked for besides.
        closed: Whether it needs cells, which the tube has not.
    """

    name: str
    entries: dict[str, str]
    script: str = ""
    watched: bool = False
    ledger: bool = False
    closed: bool = False


#: Above tube and lattices, out of reach.
PROBE = "tool probe { kind is probe; radius = 1 cm; centre = (1, 1, 60) cm }"
BELOW = "tool floor { kind is plane; point = (0, 0, -3.0) mm; normal = (0, 0, 1) }"
NOZZLE = """tool nozzle {
  kind is nozzle; diameter = 4 mm; tip = (3, 0.5, 40) cm; direction = (0, 0, -1)
}"""
FEATURES = (
    Feature("no viscosity", {"viscosity": "0 N*s/m"}),
    Feature("rupture", {}, watched=True),
    Feature("energies", {}, ledger=True),
    Feature("law `exponential`", {"tissue": "spring law is exponential { stiffening = 12 }"}),
    Feature("free formula", {"tissue": "spring force of e = c * e + 40 kN/m^3 * e^3"}),
    Feature(
        "relaxing branch", {"tissue": "relaxing constant = 100 N/m; relaxation time = 1 s"}
    ),
    Feature("yield", {"tissue": "yield force = 1 N; yield viscosity = 10 N*s/m"}),
    Feature("volume of cells", {}, script="preserve volume of block with 10 kPa", closed=True),
    Feature("a tool far away", {"around": "contact is tools only", "more": PROBE}),
    Feature("a floor that is touched", {"around": "contact is tools only", "more": BELOW}),
    Feature("and friction", {"around": "contact is tools only; friction = 0.3", "more": BELOW}),
    Feature("`bodies too`, one body", {"around": "contact is bodies too"}),
    Feature("`everywhere`", {"around": "contact is everywhere"}),
    Feature("a jet", {"more": NOZZLE}, script="irrigate with 5 ml/s through nozzle"),
)


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure all features on the tube and a lattice."""
    tube, _, lattice, *_ = nets()
    publish("features", {"features": costs(tube, lattice)}, write=write)


def costs(*chosen: Net) -> str:
    """Return the table."""
    rows = [["nothing besides", *(["1"] * len(chosen))]]
    rows += [[feature.name] for feature in FEATURES]
    for net in chosen:
        plain = stepping(net, Feature("", {}))
        for row, feature in zip(rows[1:], FEATURES, strict=True):
            if feature.closed and net.name == "tube":
                row.append("")
                continue
            run = stepping(net, feature)
            ratios = [run.time() / plain.time() for _ in range(REPEATS)]
            row.append(f"{median(ratios):.2f}")
            tell(f"{net.name}, {feature.name}: {row[-1]}")
    return table(("scene", *(net.name for net in chosen)), rows)


def stepping(net: Net, feature: Feature) -> Stepping:
    """Return an engine on a net with a feature."""
    entries = dict(feature.entries)
    if feature.script:
        entries["more"] = entries.get("more", "") + f"\nscript {{ at 0 s: {feature.script} }}"
    return Stepping(
        build(net, **entries), METHODS[0], watched=feature.watched, ledger=feature.ledger
    )


if __name__ == "__main__":
    main()
