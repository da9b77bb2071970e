"""A study from its text to its table: before, during and after its runs."""

import hashlib
import json
import math
import time as clock
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Protocol

from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.compiler.manifest import digests, sources_of
from tissuec.compiler.study.expectations import Verdict, judge
from tissuec.compiler.study.measures import compile_measures
from tissuec.core import arguments
from tissuec.core.errors import Diagnostic, TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.signals import ending
from tissuec.core.structs import replace
from tissuec.core.version import __version__
from tissuec.core.workers.workers import Lost, Workers
from tissuec.lang import syntax as s
from tissuec.pipeline import compile_program
from tissuec.results import PlaceError
from tissuec.results.places import make_folder
from tissuec.scene.program.declarations import without
from tissuec.scene.program.imports import Program, load
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request
from tissuec.scene.study.entries import INDICES, RESULTS
from tissuec.scene.study.levels import alone, check_rows
from tissuec.scene.study.model import UNNAMED, Cell, Factor, Study
from tissuec.studies.designs import Point, points_of
from tissuec.studies.journal import Journal, rows_in_hdf5
from tissuec.studies.table import (
    DIED,
    DONE,
    ENDED,
    FactorHead,
    MeasureHead,
    Row,
    StudyHead,
    StudyTable,
)
from tissuec.studies.table_files import is_hdf5
from tissuec.studies.trial import Job, PlannedRun, failed, row_of
from tissuec.studies.writing import with_sentences

KILLED = "its worker process died"
RUNS = ".runs"  # after the name of a table: the folder of results

#: Progress callback: numbers of finished runs, of failed ones among them, and of all runs.
Progress = Callable[[int, int, int], None]


class Digest(Protocol):
    """A digest of ``hashlib``, whose own type is not public."""

    def update(self, data: bytes, /) -> None:
        """Take in bytes."""

    def copy(self) -> "Digest":
        """Return another one that has taken in the same."""
        ...

    def hexdigest(self) -> str:
        """Return the digest so far."""
        ...


class PreparedStudy(Struct, frozen=True):
    """A study that can begin.

    Attributes:
        study: As it is written.
        compiled: The scene with its own values.
        head: Of the table.
        job, planned: What the workers do.
        warnings: Of the text.
    """

    study: Study
    compiled: Compiled
    head: StudyHead
    job: Job
    planned: tuple[PlannedRun, ...]
    warnings: tuple[Diagnostic, ...]

    @property
    def keeps(self) -> bool:
        """Return whether the result of each run is kept."""
        return self.study.settings.keep == RESULTS


class StudyResult(Struct, frozen=True):
    """What a study came to.

    Attributes:
        verdicts: Of its expectations.
        taken_over: Rows that an earlier study had already.
        seconds: Wall time of the runs [s].
    """

    table: StudyTable
    verdicts: tuple[Verdict, ...]
    taken_over: int
    seconds: float


def prepare(
    request: Request,
    name: str | None = None,
    *,
    sentences: Sequence[str] = (),
) -> PreparedStudy:
    """Return a study whose text, values and measures are right.

    Args:
        request: The scene.
        name: Of the study; by default the only one of the scene, or that of the sentences.
        sentences: More sentences of the block, or all of it.

    Raises:
        CompileError: The text is wrong, or values do not go with the scene.
        TissueError: There is no such study, or it has too many runs.
    """
    findings = Findings()
    program = load(request.source, request.libraries, findings, request.files)
    name = _name(program, name, request, is_written=bool(sentences))
    program = with_sentences(program, name, sentences)
    compiled, warnings = compile_program(program, request, findings, thorough=True, levels=True)
    study = compiled.scene.studies[key_of(name)]
    points = points_of(study)
    check_rows(study, points, alone(program), request.overrides, findings)
    findings.raise_errors()
    warnings = tuple(dict.fromkeys((*warnings, *findings.warnings)))
    head = _head(study, compiled, len(points))
    job = Job(
        alone(program, expects=study.settings.keep == RESULTS),
        request,
        study.measures,
        tuple(one.name for one in head.measures),
        tuple(one.every is not None for one in head.measures),
        study.estimates,
    )
    planned = tuple(_planned(study, points, _digest(study, job, compiled)))
    return PreparedStudy(study, compiled, head, job, planned, warnings)


def run_study(
    prepared: PreparedStudy,
    workers: Workers,
    *,
    out: Path | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> StudyResult:
    """Do the runs of a study that are not done yet, and return its table.

    Args:
        workers: Who does the runs.
        out: The table, which is there at any moment, and results beside it if they are kept; in
            HDF5 there is one in CSV beside it. None writes nothing.
        fresh: Whether to discard rows that are there.
        progress: Called after each run.

    Raises:
        PlaceError: The table cannot be written there.
        ResultError: Writing failed later on.
        TissueError: No worker can be reached; the rows so far are in the table.
        KeyboardInterrupt: After a signal; the rows so far are in the table.
    """
    began = clock.monotonic()
    with ending():
        if out is None:
            rows, taken = _without_file(prepared, workers, progress), 0
        else:
            rows, taken = _in_file(prepared, workers, out, fresh=fresh, progress=progress)
        table = StudyTable.of(prepared.head, rows)
        if out is not None and is_hdf5(out):
            from tissuec.studies.table_hdf5 import write_hdf5

            write_hdf5(table, out)
    return StudyResult(table, _verdicts(prepared, table), taken, clock.monotonic() - began)


def _without_file(
    prepared: PreparedStudy, workers: Workers, progress: Progress | None
) -> list[Row]:
    """Return the rows of all runs."""
    if prepared.keeps:
        raise PlaceError("results are kept beside the table; give the table a place")
    rows = list[Row]()
    tell = _Teller(progress, len(prepared.planned), ())
    for row in _rows(workers, prepared.job, prepared.planned):
        rows.append(row)
        tell.add(row)
    return rows


def _in_file(
    prepared: PreparedStudy,
    workers: Workers,
    out: Path,
    *,
    fresh: bool,
    progress: Progress | None,
) -> tuple[list[Row], int]:
    """Write the rows of all runs; returns them, and how many were there before."""
    path, job = out.with_suffix(".csv") if is_hdf5(out) else out, prepared.job
    digests = [one.digest for one in prepared.planned]
    known = rows_in_hdf5(out, prepared.head, digests, fresh=fresh) if is_hdf5(out) else None
    with Journal(path, prepared.head, digests, fresh=fresh, known=known) as journal:
        if prepared.keeps:
            folder = out.with_suffix(RUNS)
            make_folder(folder)
            job = replace(job, folder=folder.absolute())
        taken = len(journal.rows)
        left = [one for one in prepared.planned if one.run not in journal.rows]
        tell = _Teller(progress, len(prepared.planned), journal.rows.values())
        for row in _rows(workers, job, left):
            journal.add(row)
            tell.add(row)
        journal.finish()
    return list(journal.rows.values()), taken


def _rows(workers: Workers, job: Job, planned: Sequence[PlannedRun]) -> Iterator[Row]:
    """Yield the rows of runs as they come."""
    if not planned:
        return
    with workers, closing(workers.map(row_of, job, planned)) as found:
        for number, row in found:
            if isinstance(row, Lost):
                row = failed(job, planned[number], DIED, KILLED)
            yield row


class _Teller:
    """Counts rows, and reports the progress of a study."""

    def __init__(self, progress: Progress | None, planned: int, rows: Iterable[Row]):
        self.progress, self.planned = progress, planned
        self.done = self.failed = 0
        for row in rows:
            self._count(row)
        self._tell()

    def add(self, row: Row) -> None:
        """Take one more row into account."""
        self._count(row)
        self._tell()

    def _count(self, row: Row) -> None:
        self.done += 1
        self.failed += row.outcome not in (DONE, ENDED)

    def _tell(self) -> None:
        if self.progress is not None:
            self.progress(self.done, self.failed, self.planned)


def _verdicts(prepared: PreparedStudy, table: StudyTable) -> tuple[Verdict, ...]:
    columns = {
        column.name: (column.values, column.unit)
        for column in table.columns
        if not isinstance(column.values, tuple)
    }
    return judge(prepared.study.expects, columns, prepared.compiled.scene.constants)


# --- before -----------------------------------------------------------------------------------


def _name(program: Program, name: str | None, request: Request, *, is_written: bool) -> str:
    """Return the name of the study that is meant."""
    blocks = [item for item in program.main.items if isinstance(item, s.Block)]
    found = [own.text for block in blocks if (own := without(block.name, "study"))]
    by_key = {key_of(one): one for one in found}
    scene = request.source.name
    if name is not None:
        if key_of(arguments.text(name, "the name of a study")) in by_key:
            return by_key[key_of(name)]
        if is_written:
            return name
        hint = alternatives(name, found, what="there are") or "it has none"
        raise TissueError(f'"{scene}" has no study called "{name}"; {hint}')
    if is_written and len(found) != 1:
        return UNNAMED
    if not found:
        raise TissueError(f'"{scene}" has no study; write a study block, or use --vary')
    if len(found) > 1:
        raise TissueError(
            f'"{scene}" has several studies: {", ".join(found)}; name one of them'
        )
    return found[0]


def _head(study: Study, compiled: Compiled, planned: int) -> StudyHead:
    """Return the head of the table: single numbers before curves."""
    measures, _ = compile_measures(compiled, study.measures)
    heads = [MeasureHead(one.name, one.unit, one.every) for one in measures]
    heads.sort(key=lambda head: head.every is not None)
    factors = tuple(
        FactorHead(one.name, one.unit, one.is_text, one.written) for one in study.factors
    )
    base = study.settings.runs if study.design == INDICES else 0
    scene = Path(compiled.scene.source.name).stem
    return StudyHead(
        study.name, scene, study.design, study.settings.seed, base, planned, factors,
        tuple(heads),
    )  # fmt: skip


def _planned(study: Study, points: Sequence[Point], digest: Digest) -> Iterator[PlannedRun]:
    """Yield the runs of a study."""
    for run, point in enumerate(points):
        overrides = tuple(
            factor.override(value)
            for factor, value in zip(study.factors, point, strict=True)
            if value is not None
        )
        values = tuple(
            _own(factor) if value is None else value
            for factor, value in zip(study.factors, point, strict=True)
        )
        one = digest.copy()
        one.update(json.dumps(overrides).encode())
        yield PlannedRun(run, values, overrides, one.hexdigest()[:16])


def _own(factor: Factor) -> Cell:
    """Return the values of the scene itself, as the table shows them."""
    if factor.own is None:
        return "" if factor.is_text else math.nan
    return factor.own


def _digest(study: Study, job: Job, compiled: Compiled) -> Digest:
    """Return the digest of all that the rows of a study have in common."""
    found = hashlib.sha256(__version__.encode())
    for module in job.program.modules:
        parts = [item.span.text for item in module.items]
        found.update(json.dumps([module.source.name, *parts]).encode())
    facts = {
        "overrides": job.request.overrides,
        "measures": [(one.name, " ".join(one.item.span.text.split())) for one in job.measures],
        "estimates": job.estimates,
        "keep": study.settings.keep,
        "files": dict(digests(compiled)),
        "texts": dict(sources_of(compiled)),
    }
    found.update(json.dumps(facts, sort_keys=True).encode())
    return found
