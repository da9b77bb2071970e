"""``tissuec run``: Simulate scenes and write their motion to HDF5."""

import gc
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from msgspec.structs import replace

from tissuec.cli import USUAL_THRESHOLDS
from tissuec.cli.common import (
    DONE,
    FAILED,
    PAGES,
    STOPPED,
    WRONG_TEXT,
    Command,
    Settings,
    as_json,
    echo,
    keep_input,
    print_json,
    report,
    scene_options,
)  # fmt: skip
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.precision import PRECISIONS, SINGLE
from tissuec.core.units import TIME, show
from tissuec.engine.execution.signals import SIGNALLED, exit_code
from tissuec.results import wording
from tissuec.results.promise import Promise

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.engine.execution.companion import Mode
    from tissuec.engine.execution.run import Outcome
    from tissuec.model.network import Network
    from tissuec.pipeline import Result
    from tissuec.scene.request import Request

MOST_SPRINGS_NAMED = 6
RESULTS = (".vtkhdf", ".h5", ".hdf5", ".hdf")  # endings of results
# Springs from which memory counts more than the time of searching for cycles of objects.
LARGE = 1_000_000
_CODES = {"done": DONE, "diverged": STOPPED, "stuck": STOPPED}


@click.command(cls=Command)
@click.argument("scenes", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Result file (one scene only).",
)
@click.option(
    "--out",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for results.",
    metavar="DIR",
)
@click.option("--resume", is_flag=True, help="Resume an interrupted run.")
@click.option(
    "--companion",
    type=click.Choice(["auto", "process", "inline", "off"]),
    default="auto",
    help="How the companion run, with smaller steps of another method, estimates the error: "
    "in another process, afterwards in this one (inline), whichever is faster (auto), or not "
    "at all.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="Maximum number of threads for a large net; by default one for each processor, or "
    "half as many if the companion run may use the others. Results do not depend on it.",
)
@click.option(
    "--blocks",
    is_flag=True,
    help="Also write a blocks file for ParaView, with the parts of bodies, joints and tools.",
)
@click.option(
    "--precision",
    type=click.Choice(PRECISIONS),
    help="Precision of frames and surfaces in the result, instead of that of the scene.",
)
@click.option("--compress", is_flag=True, help="Compress frames and surfaces, without loss.")
@click.option("--twin/--no-twin", default=None, hidden=True, help="Former names: auto, off.")
@scene_options
def command(
    settings: Settings,
    scenes: tuple[Path, ...],
    output: Path | None,
    folder: Path | None,
    resume: bool,
    companion: "Mode",
    threads: int | None,
    blocks: bool,
    precision: str | None,
    compress: bool,
    twin: bool | None,
    **options: Any,
) -> int:
    """Simulate SCENES; scene.tis gives scene.vtkhdf in the current directory.

    ParaView, H5MD readers and h5py open the result. When the run ends, it replaces an earlier
    result of the same name, but no other file. Exit code: 0 done; 1 an expectation failed or,
    with --strict, numbers are doubtful or their error exceeds the tolerance or is unknown; 2
    the text or the command line is wrong; 3 the run could not continue; 130 interrupted (143 by
    SIGTERM, 129 by SIGHUP).
    """
    _check_endings(output, folder)
    if output is not None and (len(scenes) > 1 or folder is not None):
        raise click.UsageError("-o names the result of one scene; use --out DIR for several")
    storage = _Storage(precision, compress)
    if resume and storage.is_asked_for:
        raise click.UsageError(
            "a resumed run keeps the storage with which it began: omit --precision and "
            "--compress"
        )
    companion = "off" if twin is False else companion
    codes: list[int] = []
    documents: list[dict[str, Any]] = []
    for path, target in _targets(scenes, output, folder).items():
        again = _again(path, output, folder, blocks=blocks, **options)
        code, document = _run_one(
            path,
            target,
            again,
            settings,
            resume=resume,
            companion=companion,
            threads=threads,
            blocks=blocks,
            storage=storage,
            **options,
        )
        codes.append(code)
        documents.append(document)
        if code > SIGNALLED:
            break
    if settings.json:
        print_json(documents[0] if len(scenes) == 1 else documents)
    return max(codes)


class _Storage(NamedTuple):
    """How frames are stored, as far as the command line says it."""

    precision: str | None
    compress: bool

    @property
    def is_asked_for(self) -> bool:
        """Return whether it differs from what the scene says."""
        return self.compress or self.precision is not None

    def of(self, compiled: "Compiled") -> "Compiled":
        """Return a scene with this storage; PlaceError if it stores no frames."""
        from tissuec.results.errors import PlaceError

        output = compiled.plan.output
        if not self.is_asked_for:
            return compiled
        if not (len(output.frames) or output.surfaces):
            option = "--compress" if self.compress else "--precision"
            raise PlaceError(
                f"{compiled.scene.source.name} records no frames for {option}; write in the "
                "scene: output { trajectory every 10 ms }"
            )
        single = output.single if self.precision is None else self.precision == SINGLE
        output = replace(output, single=single, compress=self.compress or output.compress)
        return replace(compiled, plan=replace(compiled.plan, output=output))


#: What writes files of other kinds from a result, by their endings.
_OTHERS = {
    "export": (
        ".csv",
        ".tsv",
        ".txt",
        ".xlsx",
        ".json",
        ".vtk",
        ".vtu",
        ".pvd",
        ".stl",
        ".obj",
    ),
    "plot": (".png", ".svg", ".pdf", ".jpg", ".jpeg"),
    "view": (*PAGES, ".mp4", ".gif", ".webm"),
}


def _check_endings(output: Path | None, folder: Path | None) -> None:
    """Refuse names of results that promise another kind of file, or a file for a folder.

    Raises:
        UsageError: A name ends so.
    """
    if folder is not None and folder.suffix.lower() in RESULTS and not folder.is_dir():
        raise click.UsageError(f'--out names a folder; for a file, write "-o {folder}"')
    if output is None:
        return
    for other, endings in _OTHERS.items():
        if output.suffix.lower() in endings:
            result = output.with_suffix(".vtkhdf")
            raise click.UsageError(
                f'a result is an HDF5 file, unlike "{output}"; write "-o {result}", and then: '
                f"tissuec {other} {result}"
            )


def _targets(
    scenes: tuple[Path, ...], output: Path | None, folder: Path | None
) -> dict[Path, Path]:
    """Return where the result of each scene goes; TissueError if that would lose a file."""
    from tissuec.results.places import SUFFIX, final_path, partial_path

    targets: dict[Path, Path] = {}
    owners: dict[Path, Path] = {}
    for path in scenes:
        target = targets[path] = output or (folder or Path()) / f"{path.stem}{SUFFIX}"
        partial = partial_path(target)
        if path.suffix != SUFFIX:  # a result that is given as a scene is refused as such
            for place in (partial, final_path(partial)):
                keep_input(place, path)
        owner = owners.setdefault(final_path(partial).resolve(), path)
        if owner is not path:
            raise TissueError(
                f'the results of "{owner}" and "{path}" would both be "{target}"; run one of '
                "them separately, with -o"
            )
    return targets


def _again(
    path: Path, output: Path | None, folder: Path | None, *, blocks: bool,
    overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
) -> str:  # fmt: skip
    """Return the command line that goes on with a run."""
    options = [("-o", output), ("--out", folder), *wording.set_options(overrides, libraries)]
    return wording.command(path, options, resume=True, strict=strict, blocks=blocks)


def _run_one(
    path: Path, target: Path, again: str, settings: Settings, *,
    resume: bool, companion: "Mode", threads: int | None, blocks: bool, storage: _Storage,
    overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
) -> tuple[int, dict[str, Any]]:  # fmt: skip
    from tissuec.compiler.manifest import outcome_facts
    from tissuec.core.progress import compiling
    from tissuec.pipeline import compile_request
    from tissuec.results.errors import PlaceError
    from tissuec.results.places import make_folder
    from tissuec.scene.request import Request

    document: dict[str, Any] = {"scene": str(path), "ok": False}
    try:
        request = Request.file(path, overrides=overrides, libraries=libraries, strict=strict)
        with compiling(request.source.name, shown=settings.shows_progress):
            compiled, warnings = compile_request(request)
    except CompileError as error:
        if not settings.json:
            report(error.diagnostics, settings)
        return WRONG_TEXT, document | {"diagnostics": as_json(error.diagnostics)}
    if not settings.json:
        report(warnings, settings)
    if compiled.network.spring_count > LARGE:
        gc.set_threshold(*USUAL_THRESHOLDS)
    try:
        make_folder(target.parent)
        result = _with_progress(
            storage.of(compiled),
            request,
            target,
            settings,
            resume=resume,
            companion=companion,
            threads=threads,
            blocks=blocks,
        )
    except TissueError as error:
        if not settings.json:
            echo(f"error: {error}", err=True)
        code = WRONG_TEXT if isinstance(error, PlaceError) else STOPPED
        return code, document | {"error": str(error)}
    outcome = result.outcome
    facts = {
        **outcome_facts(compiled.plan, outcome, result.estimate),
        "wall_time": outcome.wall_time,
    }
    code = _code_of(outcome, facts, strict=strict)
    document |= _document(compiled, result, facts) | {
        "ok": code == DONE,
        "diagnostics": as_json(warnings),
    }
    interrupted = outcome.kind == "interrupted"
    if interrupted:
        document["go_on_with"] = again
    if not settings.json:
        _tell(path, compiled, result, facts, settings)
        if interrupted:
            settings.say(f"  resume with: {again}")
    return code, document


def _code_of(outcome: "Outcome", facts: Mapping[str, Any], *, strict: bool) -> int:
    """Return the exit code of a run that has begun."""
    if outcome.kind == "interrupted" or outcome.signal is not None:
        return exit_code(outcome.signal)
    is_off = strict and (Promise.of(facts).since is not None or outcome.doubts)
    is_done = _CODES[outcome.kind] == DONE
    return FAILED if is_done and (outcome.failures or is_off) else _CODES[outcome.kind]


def _with_progress(
    compiled: "Compiled", request: "Request", target: Path, settings: Settings, *,
    resume: bool, companion: "Mode", threads: int | None, blocks: bool,
) -> "Result":  # fmt: skip
    from tissuec.core.progress import RunProgress
    from tissuec.pipeline import simulate

    duration = compiled.plan.simulation.duration
    name, shown = request.source.name, settings.shows_progress
    with RunProgress(name, duration, shown=shown) as progress:
        return simulate(
            compiled,
            target,
            request=request,
            resume=resume,
            companion=companion,
            threads=threads,
            blocks=blocks,
            progress=progress.at,
        )


def _tell(
    path: Path, compiled: "Compiled", result: "Result", facts: Mapping[str, Any],
    settings: Settings,
) -> None:  # fmt: skip
    """Say on stderr what came out."""
    from tissuec.results.recording import ExpectationResult

    outcome, network = result.outcome, compiled.network
    if outcome.kind in ("done", "interrupted"):
        settings.say(f"{path}: {outcome.message}")
    else:
        echo(f"{path}: {outcome.message}", err=True)  # an error, which no -q hides
    settings.say(f"  {network.size}; {wording.stepping(facts)}")
    for note in outcome.notes:
        settings.say(f"  note: {note}")
    known: set[str] = set()
    doubted = {doubt.what for doubt in outcome.doubts}
    for time, logged_event in outcome.logged_events:
        # What slips or leaks once may continue to do so in many small steps.
        subjects = {"slip": logged_event.cause, "leak": logged_event.span.place}
        subject = subjects.get(logged_event.kind)
        is_first = subject is not None and subject not in known
        if subject is not None:
            known.add(subject)
        is_note = logged_event.kind == "note" and logged_event.cause not in doubted
        if settings.verbose or is_first or is_note or logged_event.kind == "trigger":
            springs = _springs(network, logged_event.springs)
            what = f"{logged_event.kind}{springs}: {logged_event.cause}"
            settings.say(f"  {show(time, TIME)}: {what} ({logged_event.span.place})")
    for line in wording.springs_of_events(
        ((e.kind, e.springs) for _, e in outcome.logged_events), network.first_mark
    ):
        settings.say(f"  {line}")
    expectations = [ExpectationResult(**one) for one in facts["expectations"]]
    for one in expectations:
        if one.state == "fails":
            expectation, measured = wording.failure(one)
            echo(f"  FAILED {expectation}\n         {measured}", err=True)
    if expectations:
        said = wording.expectations([one.state for one in expectations])
        settings.say(f"  expectations: {said}")
    for doubt in outcome.doubts:
        echo(f"  doubtful: {doubt}", err=True)
    if "promise" in facts:
        _tell_accuracy(Promise.of(facts), settings)
    settings.say(f"  result: {result.path}")
    for name, view in result.views.items():
        settings.say(f"  surface of {name}: {view}")
    if result.blocks is not None:
        settings.say(f"  blocks: {result.blocks}")
    for sentence in result.left_out:
        settings.say(f"  note: {sentence}")


def _springs(network: "Network", springs: Sequence[int]) -> str:
    """Return which springs something happened to, by the author's ids."""
    marks = [spring for spring in springs if spring >= network.first_mark]
    if not springs or marks:  # of elements, the cause says which
        return ""
    ids = ", ".join(str(network.springs.ids[spring]) for spring in springs[:MOST_SPRINGS_NAMED])
    more = ", …" if len(springs) > MOST_SPRINGS_NAMED else ""
    return f" of spring{'s' if len(springs) > 1 else ''} {ids}{more}"


def _tell_accuracy(promise: Promise, settings: Settings) -> None:
    """Say how accurate positions are, loudly where they are not as promised."""
    said = wording.accuracy(promise)
    if promise.since is not None:
        echo(f"  warning: {said}", err=True)
    else:
        verb = "" if promise.differs else "; checked"
        took = "" if promise.error is None else f"{verb} in {promise.seconds:.2f} s"
        settings.say(f"  accuracy: {said}{took}")


def _document(
    compiled: "Compiled", result: "Result", facts: Mapping[str, Any]
) -> dict[str, Any]:
    outcome, expectations = result.outcome, facts["expectations"]
    return {
        "result": str(result.path),
        "surfaces": {name: str(view) for name, view in result.views.items()},
        "blocks": None if result.blocks is None else str(result.blocks),
        "left_out": list(result.left_out),
        "outcome": outcome.kind,
        "message": outcome.message,
        "wall_time": outcome.wall_time,
        **compiled.network.size.facts,
        "statistics": facts["statistics"],
        "notes": facts["notes"],
        "doubts": facts["doubts"],
        "events": [
            {
                "time": t,
                "kind": h.kind,
                "springs": list(h.springs),
                "cause": h.cause,
                "place": h.span.place,
            }
            for t, h in outcome.logged_events
        ],
        "expectations": len(expectations),
        "failures": [
            {name: one[name] for name in ("expect", "time", "measured")}
            for one in expectations
            if one["state"] == "fails"
        ],
        "promise": str(Promise.of(facts)),
        "error_estimate": facts.get("promise"),
        "unreached": [one["expect"] for one in expectations if one["state"] == "not reached"],
    }
