"""The laboratory: all tests of a tissue, compared with evidence."""

from tissuec.analysis.lab.bench import TestBench
from tissuec.analysis.lab.examiner import Listener
from tissuec.analysis.lab.rows import Examination, TestRow
from tissuec.analysis.lab.solid_tests import SolidExaminer
from tissuec.analysis.lab.spring_tests import SpringExaminer
from tissuec.compiler.provenance import used_tissues
from tissuec.core import arguments
from tissuec.core.errors import TissueError
from tissuec.core.hints import did_you_mean
from tissuec.core.names import key_of
from tissuec.core.source import Source
from tissuec.scene.model import Tissue
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.request import Request

SPACING = 2.5e-3  # [m], where quantities belong to springs


def chosen(words: ResolvedProgram, name: str | None, source: Source) -> list[Tissue]:
    """Return the tissue of a name; otherwise those of bodies, or all tissues of a file.

    Args:
        name: Name of a tissue; None for all.
        source: The file.

    Raises:
        TissueError: There is none.
    """
    known = words.tissues
    if name is not None and key_of(arguments.text(name, "tissue")) not in known:
        hint = did_you_mean(key_of(name), known) or f"tissues: {', '.join(known)}"
        raise TissueError(f'there is no tissue "{name}"; {hint}')
    if name is not None:
        return [known[key_of(name)]]
    if words.declarations.of("body"):
        return used_tissues(words)
    found = [one for one in known.values() if one.span.source.name == source.name]
    if not found:
        raise TissueError(f'"{source.name}" does not declare a tissue')
    return found


def examine(
    request: Request,
    tissue: Tissue,
    *,
    spacing: float = SPACING,
    thickness: float | None = None,
    listener: Listener | None = None,
) -> Examination:
    """Return the results of all tests of a tissue.

    Args:
        request: The text that declares it.
        spacing: Length of cells, if its quantities belong to springs [m].
        thickness: Of strips of a sheet [m]; None for bars.
        listener: Called with each row once it is measured.

    Raises:
        TissueError: It has no stiffness, or none that depends on a thickness.
        CompileError: No coupon can be made of it.
    """
    bench = TestBench(request, tissue, spacing=spacing, thickness=thickness)
    if not bench.is_of_matter and bench.lacks("spring constant") and not tissue.laws:
        raise TissueError(
            f'tissue {tissue.name} cannot be tested: it has no "Young\'s modulus"'
        )
    if thickness is not None and not bench.is_of_matter:
        raise TissueError(
            f"tissue {tissue.name} cannot be tested as strips: a thickness does not affect "
            "quantities of springs"
        )
    return examiner_of(bench, listener or _ignore).all()


def examiner_of(bench: TestBench, listener: Listener) -> SolidExaminer | SpringExaminer:
    """Return the tests of a tissue.

    Args:
        listener: Callback for each row.
    """
    return (SpringExaminer if bench.of_springs or bench.thickness else SolidExaminer)(
        bench, listener
    )


def _ignore(row: TestRow) -> None:
    """Ignore a row."""
