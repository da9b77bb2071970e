"""Check of cells that are many times as long as thick."""

from collections.abc import Iterator

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.arrays import norm
from tissuec.core.errors import Diagnostic, counted
from tissuec.core.units import LENGTH, show

MOST = 100.0  # ratio of edges; bars of such cells still bend with an error of 1e-5


@check
def slender_cells(compiled: Compiled) -> Iterator[Diagnostic]:
    """W216: cells whose edges differ by more than a factor of 100."""
    network = compiled.network
    parts = {part.name: part for part in network.bodies}
    for one in network.of_kind("elements"):
        if one.shape.name == "tetrahedron" or not one.item_count:
            continue
        from tissuec.geometry.elements import SHAPES  # where there are elements

        # Those between corners, also where there are nodes in their middles.
        shape = SHAPES["hexahedron"] if one.shape.functions > 1 else one.shape
        ends = network.position[one.nodes[:, shape.edges]]
        edges = norm(ends[:, :, 1] - ends[:, :, 0])
        long, short = edges.max(axis=1), edges.min(axis=1)
        ratio = long / short
        if not (many := int((ratio > MOST * (1.0 + 1e-9)).sum())):
            continue
        worst = int(ratio.argmax())
        shown = [show(float(each[worst]), LENGTH, digits=3) for each in (long, short)]
        yield Diagnostic(
            "W216",
            f"{counted(many, 'cell')} of {one.name} {'is' if many == 1 else 'are'} up to "
            f"{ratio[worst]:.0f} times as long as thick ({shown[0]} and {shown[1]})",
            parts[one.name].span,
            "the shortest edge limits the step, and slender bodies lose digits: use edges of "
            f"{show(float(long[worst]) / MOST, LENGTH, digits=3)} or more, or make the others "
            "shorter",
        )
