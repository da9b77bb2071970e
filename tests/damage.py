"""Damage results in every way, and put them before every command that reads results.

    python -m tests.damage --count 1000 --seed 1

Bytes are flipped, files cut short, datasets and attributes removed, retyped, resized and
changed. Each damaged file is read in a process of its own, with a limit of memory and time.
Whatever is wrong must be a ResultError that names the file. Prints a JSON document of what else
came about; exits with 1 if there was any.
"""

import argparse
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click
import h5py
import numpy as np

import tissuec
from tissuec.results import ResultError

#: A scene with all that a result can hold: tools, threads, joints, sets, regions, laws, memory.
SCENE = """language 1
param drawn = 4 mm
tissue skin {
  spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 0.2 g; breaking force = 60 mN
  spring law is toe { strain = 3 % }
}
tissue cord {
  spring constant = 60 N/m; viscosity = 5 mN*s/m; mass = 0.1 g
  relaxing constant = 20 N/m; relaxation time = 10 ms
}
body sheet {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 4; rows = 4; diagonals is both
  }
  tissue is skin; rupture is allowed
}
body rope { mesh is explicit; tissue is cord }
table nodes of rope in mm with columns "id x y z" { 1 0 0 9; 2 10 0 9; 3 20 0 9 }
table springs of rope with columns "a b" { 1 2; 2 3 }
body sling {
  mesh is thread { centre = (10, 0, 30) mm; normal = (1, 0, 0); radius = 4 mm; pieces = 8
                   thickness = 1 mm }
  tissue is cord
}
set left = nodes of sheet where x < 1 mm
set right = nodes of sheet where x > 19 mm
set cords = springs of rope
set near = nodes of rope where x < 1 mm
joint seam { springs from near to left; reach = 30 mm; tissue is cord }
tool finger { kind is probe; radius = 2 mm; centre = (10, 10, -9) mm }
environment {
  gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m
  contact is tools only; contact stiffness = 20 N/m; contact layer = 0.5 mm; friction = 0.2
}
script {
  at 0 s: { fix left; hold right; fix rope; fix sling }
  from 1 ms to 6 ms: move right by (drawn, 0 mm, 0 mm) using smooth profile
  from 1 ms to 5 ms: move finger by (0, 0, 8) mm using smooth profile
  at 6 ms: cut sheet along line from (12, -1, 0) mm to (12, 9, 0) mm facing (1, 0, 0)
}
simulate { duration = 8 ms; tolerance = 5e-2 }
output {
  trajectory every 1 ms; force of right every 0.4 ms; tension of cords every 0.4 ms
  energy every 1 ms; surface of sheet every 2 ms
}
expect count(springs of sheet) > 1 over run
"""
PROPERTIES = (
    "times", "ends", "node_ids", "spring_ids", "sets", "bodies", "holds", "provenance",
    "sources", "text", "outcome", "finished", "expectations", "events", "promise",
)  # fmt: skip
SECONDS, MEMORY = 60, 4 << 30  # [s], [byte]
NUMBERS = (0, -1, 1, 2**31 - 1, -(2**63), 2**40, np.nan, np.inf, 1e300, -1e-300)
Change = Callable[[random.Random, h5py.File], None]


def members(file: h5py.File, kind: type = h5py.Dataset) -> list[str]:
    """Return the paths of all datasets, or of all groups."""
    found: list[str] = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, kind) else None)
    return sorted(found)


def anything(dice: random.Random) -> object:
    """Return a value of any kind and shape."""
    return dice.choice([
        dice.choice(NUMBERS), "text", b"\xff\xfe", np.zeros((0,)), np.zeros((2, 2, 2)),
        np.arange(7), np.array([1.5, np.nan]), np.array([b"a", b"\xff"]), True,
        "{}", "[1]", "null",
        np.zeros(3, dtype=[("a", "i4"), ("b", "f8")]), h5py.Empty("f8"), 1j,
        np.array(["a", "b"], dtype=h5py.string_dtype()),
    ])  # fmt: skip


def remove(dice: random.Random, file: h5py.File) -> None:
    del file[dice.choice(members(file, dice.choice([h5py.Dataset, h5py.Dataset, h5py.Group])))]


def retype(dice: random.Random, file: h5py.File) -> None:
    path = dice.choice(members(file))
    data, about = file[path][()], dict(file[path].attrs)
    kind = dice.choice(["f4", "f8", "i1", "i8", "u2", "S5", h5py.string_dtype(), "c16", "b1"])
    try:
        with np.errstate(all="ignore"):
            data = np.asarray(data).astype(kind)
        if h5py.check_string_dtype(np.dtype(kind)):  # numbers are no texts
            data = np.array([str(one) for one in data.reshape(-1)], kind).reshape(data.shape)
    except (ValueError, TypeError, OverflowError):
        data = np.zeros(np.shape(data), "i4")
    del file[path]
    file.create_dataset(path, data=data)
    for name, value in about.items():
        file[path].attrs[name] = value


def replace(dice: random.Random, file: h5py.File) -> None:
    path = dice.choice(members(file))
    about = dict(file[path].attrs)
    del file[path]
    value = anything(dice)
    file[path] = value.encode() if isinstance(value, str) and dice.random() < 0.5 else value
    for name, given in about.items():
        file[path].attrs[name] = given


def regroup(dice: random.Random, file: h5py.File) -> None:
    """Put a group in the place of a dataset, or a dataset in that of a group."""
    path = dice.choice(members(file))
    del file[path]
    file.create_group(path)


def resize(dice: random.Random, file: h5py.File) -> None:
    path = dice.choice([p for p in members(file) if file[p].chunks])
    size = list(file[path].shape)
    axis = dice.randrange(len(size))
    size[axis] = dice.choice([0, max(size[axis] - 1, 0), size[axis] + 1, 3 * size[axis] + 5])
    if dice.random() < 0.2 and file[path].maxshape[0] is None:
        size[0] = 1 << 57  # an exbibyte that is declared, and not there
    try:
        file[path].resize(size)
    except (ValueError, TypeError, RuntimeError):
        file[path].resize(size[0] // 2 if size[0] < 1 << 50 else 1 << 50, axis=0)


def reshape(dice: random.Random, file: h5py.File) -> None:
    path = dice.choice(members(file))
    data, about = np.asarray(file[path][()]), dict(file[path].attrs)
    data = dice.choice(
        [data.reshape(-1), data[None], data.T, data.reshape(-1)[:1], data[..., None]]
    )
    del file[path]
    file[path] = data
    for name, value in about.items():
        file[path].attrs[name] = value


def renumber(dice: random.Random, file: h5py.File) -> None:
    paths = [p for p in members(file) if file[p].size and file[p].dtype.kind in "iuf"]
    path = dice.choice(paths)
    data = file[path][()]
    flat = np.atleast_1d(np.asarray(data)).reshape(-1)
    for _ in range(dice.choice([1, 1, 3])):
        place = dice.randrange(flat.size)
        value = dice.choice(NUMBERS) if dice.random() < 0.7 else float(flat[place]) + 1
        if flat.dtype.kind == "f" or np.isfinite(value):
            with np.errstate(all="ignore"):
                flat[place] = np.float64(value).astype(flat.dtype)
    file[path][...] = flat.reshape(np.shape(data))


def reword(dice: random.Random, file: h5py.File) -> None:
    paths = [p for p in members(file) if h5py.check_string_dtype(file[p].dtype)]
    path = dice.choice(paths)
    data = file[path][()]
    strange = dice.choice(
        [b"\xff\xfe\xfa", b"", b"{", b"(" * 3000, b"\x1b[31m", b"c * (", b"nan"]
    )
    if isinstance(data, bytes):
        at = dice.randrange(len(data.rstrip(b"\0")) + 1)
        data = dice.choice([strange, data[:at] + strange + data[at:], data[:at]])
        about = dict(file[path].attrs)
        del file[path]
        file.create_dataset(path, data=np.array(data, dtype=f"S{max(len(data), 1)}"))
        file[path].attrs.update(about)
    elif len(data):
        data[dice.randrange(len(data))] = strange
        file[path][...] = data


def rewrite(dice: random.Random, file: h5py.File) -> None:
    """Change an entry of the manifest."""
    path = "tissuec/manifest"
    manifest = json.loads(file[path][()].rstrip(b"\0"))
    inner = manifest
    while isinstance(inner, dict) and inner:
        key = dice.choice(sorted(inner))
        if isinstance(inner[key], dict | list) and inner[key] and dice.random() < 0.6:
            inner = inner[key]
            continue
        break
    if isinstance(inner, list):
        key = dice.randrange(len(inner))
    if dice.random() < 0.3 and isinstance(inner, dict):
        inner.pop(key, None)
    elif inner:
        inner[key] = dice.choice([None, -1, 1e300, "text", [], {}, [1], {"a": None}, True])
    about = dict(file[path].attrs)
    del file[path]
    file[path] = json.dumps(manifest)
    file[path].attrs.update(about)


def attribute(dice: random.Random, file: h5py.File) -> None:
    every = ["/", *members(file), *members(file, h5py.Group)]
    path = dice.choice([p for p in every if len(file[p].attrs)])
    attributes = file[path].attrs
    name = dice.choice(sorted(attributes))
    if dice.random() < 0.5:
        del attributes[name]
    else:
        attributes[name] = anything(dice)


CHANGES: tuple[Change, ...] = (
    remove, retype, replace, regroup, resize, reshape, renumber, renumber, reword, rewrite,
    attribute,
)  # fmt: skip


def flip(dice: random.Random, path: Path) -> None:
    data = bytearray(path.read_bytes())
    # The tables of the file are where the structure is; its numbers are most of it.
    last = dice.choice([3000, 20_000, len(data)])
    for _ in range(dice.choice([1, 2, 8])):
        data[dice.randrange(min(last, len(data)))] ^= 1 << dice.randrange(8)
    path.write_bytes(data)


def cut_short(dice: random.Random, path: Path) -> None:
    data = path.read_bytes()
    keep = dice.randrange(len(data))
    path.write_bytes(data[:keep] + bytes(dice.choice([0, len(data) - keep])))


def damage(dice: random.Random, path: Path) -> str:
    """Damage a file; return how."""
    how = dice.random()
    if how < 0.25:
        flip(dice, path)
        return "flip"
    if how < 0.3:
        cut_short(dice, path)
        return "cut_short"
    whole = path.read_bytes()
    while True:
        change = dice.choice(CHANGES)
        with suppress(
            ValueError, TypeError, OSError, OverflowError, RuntimeError
        ):  # not every value fits
            with h5py.File(path, "r+") as file:
                change(dice, file)
            return change.__name__
        path.write_bytes(whole)


def load_all(path: Path, _: Path) -> None:
    """Read everything from Python."""
    with tissuec.load(path) as run:
        repr(run), run._repr_html_()
        for array in (run.position, run.velocity, run.force, run.tension, run.tools):
            if array is not None:
                repr(array), array[:], array[-1:]
        for name in PROPERTIES:
            getattr(run, name)
        for log in (*run.logs.values(), run.energies, run.errors, run.companion):
            if log is not None:
                repr(log), log.time, log.value
        for surface in run.surfaces.values():
            for frame in range(len(surface)):
                surface.position(frame), surface.triangles(frame)
        for frame in range(len(run.times)):
            run.spring_force(frame), run.cells(frame)
        run.nodes_of("right"), run.springs_of("rope"), run.events
        run.checkpoint()
        run.save(path.with_name("saved.vtkhdf"))


def command(*words: str) -> Callable[[Path, Path], None]:
    """Return a command line as a function of a damaged file and a whole one."""

    def carry_out(path: Path, whole: Path) -> None:
        from tissuec.cli import group

        names = {"FILE": str(path), "WHOLE": str(whole), "SCENE": str(whole.with_name("s.tis"))}
        group.main([names.get(word, word) for word in words], standalone_mode=False)

    carry_out.__name__ = " ".join(words)
    return carry_out


READERS: tuple[Callable[[Path, Path], None], ...] = (
    load_all,
    command("info", "FILE"),
    command("export", "FILE", "-o", "all.csv"),
    command("export", "FILE", "--all", "-o", "frame.vtu"),
    command("export", "FILE", "events"),
    command("export", "FILE", "--surface", "sheet", "-o", "s.vtkhdf"),
    command("compare", "FILE", "WHOLE"),
    command("view", "FILE", "-o", "page.html"),
)
SLOW_READERS = (
    command("plot", "FILE", "-o", "plot.svg"),
    command("report", "FILE", "-o", "report.html"),
    command("view", "FILE", "--png", "still.png"),
)
RESUME = command("run", "SCENE", "-o", "FILE", "--resume", "--companion", "off")


def judged(read: Callable[[Path, Path], None], path: Path, whole: Path) -> str | None:
    """Return what came about that is no ResultError; None if all is well."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            read(path, whole)
    except ResultError as error:
        if path.name not in str(error) or "\n" in str(error):
            return f"no name, or no sentence: {error!r}"
    except (click.ClickException, click.exceptions.Exit, ValueError) as error:
        # Names that were asked for and are not there.
        if not isinstance(error, ValueError) or not str(error).startswith("there are no"):
            return None if not isinstance(error, ValueError) else _last(error)
    except (Exception, RecursionError, MemoryError) as error:
        return _last(error)
    return None


def _last(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/tissuec/" in f.filename] or frames
    place = f"{ours[-1].filename.rpartition('/tissuec/')[2]}:{ours[-1].lineno}"
    return f"{type(error).__name__} at {place}: {str(error)[:90]}"


def one(number: int, seed: int, folder: Path, *, quick: bool) -> dict[str, str]:
    """Damage a file and read it by all means, or by two; return what came about, by reader."""
    dice = random.Random(f"{seed} {number}")
    is_partial = number % 4 == 3
    given = folder / ("part.partial.vtkhdf" if is_partial else "whole.vtkhdf")
    here = folder / f"case{number}"
    here.mkdir()
    path = here / ("bad.partial.vtkhdf" if is_partial else "bad.vtkhdf")
    shutil.copyfile(given, path)
    os.chdir(here)
    how = damage(dice, path)
    readers = [*READERS, SLOW_READERS[number % len(SLOW_READERS)]]
    if is_partial:
        readers = [*READERS[: 2 + number % 6], RESUME]
    if quick:
        readers = [READERS[1], readers[number // 2 % len(readers)]]
    found = {}
    for read in readers:
        if (flaw := judged(read, path, folder / "whole.vtkhdf")) is not None:
            found[f"{number} {how}: {read.__name__}"] = flaw
    return found


def isolated(number: int, seed: int, folder: Path, *, quick: bool) -> dict[str, str]:
    """Return the same from a process of its own, which may crash, hang or eat memory."""
    said = folder / f"said{number}"
    child = os.fork()
    if not child:
        try:
            quiet = os.open(os.devnull, os.O_WRONLY)
            os.dup2(quiet, 1)
            os.dup2(quiet, 2)
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            signal.alarm(SECONDS)
            said.write_text(json.dumps(one(number, seed, folder, quick=quick)))
        except BaseException as error:
            said.write_text(json.dumps({f"{number}": f"harness: {_last(error)}"}))
        finally:
            os._exit(0)
    _, status = os.waitpid(child, 0)
    shutil.rmtree(folder / f"case{number}", ignore_errors=True)
    if not said.exists():
        return {f"{number}": f"ended by signal {os.WTERMSIG(status)}"}
    return json.loads(said.read_text())


def prepare(folder: Path, *, quick: bool) -> None:
    """Write a whole result, and that of an interrupted run."""
    scene = folder / "s.tis"
    scene.write_text(SCENE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tissuec.run(scene, out=folder / "whole.vtkhdf", companion="inline").close()
        signalled = []

        def stop_late(time: float) -> None:
            if time > 0.006 and not signalled:
                signalled.append(time)
                os.kill(os.getpid(), signal.SIGINT)

        with suppress(KeyboardInterrupt):
            tissuec.run(scene, out=folder / "part.vtkhdf", progress=stop_late, companion="off")
    whole = folder / "whole.vtkhdf"
    os.chdir(folder)
    for read in (
        READERS if quick else (*READERS, *SLOW_READERS)
    ):  # once, so that all is imported
        if (flaw := judged(read, whole, whole)) is not None:
            raise SystemExit(f"{read.__name__} of a whole file: {flaw}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    found: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        keep = os.dup(1), os.dup(2)
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        prepare(folder, quick=arguments.quick)
        os.dup2(keep[0], 1)
        if arguments.only is not None:
            found = one(arguments.only, arguments.seed, folder, quick=False)
        else:
            for number in range(arguments.count):
                found |= isolated(number, arguments.seed, folder, quick=arguments.quick)
        os.chdir("/")
    kinds = Counter(flaw for flaw in found.values())
    print(json.dumps({"found": found, "kinds": kinds.most_common()}, indent=1))
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
