"""Commands in a folder full of files of others: none of them is run, none of them is lost."""

import hashlib
import os
import re
import subprocess
import sys

import pytest

import tissuec
from tests.test_cli import OSCILLATOR

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links as on POSIX")
PLAIN = OSCILLATOR.replace("duration = 0.5 s", "duration = 0.2 s")
SCENE = (
    PLAIN
    + """
study pulls {
  vary pull = 0.5 mm to 1.5 mm in 3 steps
  measure far = max(force of left)
}
learn thread {
  data = "data.csv"
  time using column "t" in s
  fit = force(left along (1, 0, 0)) using column "f" in N
  adjust = [spring constant]
}
"""
)
#: Modules that interpreters, and libraries that tissuec uses, may import.
NAMES = sorted(
    {name for name in sys.stdlib_module_names if not name.startswith("__")}
    | {"PIL", "click", "h5py", "imageio_ffmpeg", "lark", "llvmlite", "matplotlib", "msgspec"}
    | {"numba", "numpy", "platformdirs", "pygls", "scipy", "sitecustomize", "usercustomize"}
)
#: A command, and the files that it writes.
COMMANDS = {
    "run": (["run", "pair.tis", "--companion", "process", "-o", "out.vtkhdf"], ["out.vtkhdf"]),
    "study": (["study", "pair.tis", "--workers", "2", "-o", "out.csv"], ["out.csv"]),
    "check": (["check", "pair.tis"], []),
    "fmt": (["fmt", "link.tis"], ["scene behind.tis"]),
    "explain": (["explain", "pair.tis"], []),
    "words": (["words", "fuzzy/soft_tissue", "--explore", "-o", "out.html"], ["out.html"]),
    "copy": (["library", "copy", "two_masses", "out.tis", "--force"], ["out.tis"]),
    "inline": (
        ["run", "pair.tis", "--companion", "inline", "-o", "out.vtkhdf"],
        ["out.vtkhdf"],
    ),
    "info": (["info", "done.vtkhdf"], []),
    "export": (["export", "done.vtkhdf", "-o", "out.csv"], ["out.csv"]),
    "frame": (["export", "done.vtkhdf", "-o", "out.vtu", "--frame", "0"], ["out.vtu"]),
    "view": (["view", "done.vtkhdf", "-o", "out.html"], ["out.html"]),
    "still": (["view", "done.vtkhdf", "--png", "out.png"], ["out.png"]),
    "plot": (["plot", "done.vtkhdf", "-o", "out.png"], ["out.png"]),
    "report": (["report", "done.vtkhdf", "-o", "out.html"], ["out.html"]),
    "compare": (["compare", "done.vtkhdf", "done.vtkhdf"], []),
    "validate": (["validate", "pair.tis"], []),
    "modes": (["modes", "free.tis"], []),
    "learn": (
        ["learn", "pair.tis", "-o", "out.tis", "--anyway", "--workers", "2"],
        ["out.tis"],
    ),
    "bench": (["bench", "pair.tis"], []),
    "completion": (["completion", "bash"], []),
}
SHORT = ("run", "study", "fmt")  # of which the first two start interpreters


def content(folder):
    """Return what each file is: a link, or the digest of its bytes."""
    return {
        path.relative_to(folder).as_posix(): (
            os.readlink(path)
            if path.is_symlink()
            else hashlib.sha256(path.read_bytes()).hexdigest()
        )
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or path.is_file()
    }


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("done") / "done.vtkhdf"
    tissuec.run(PLAIN, out=path, companion="off").close()
    return path.read_bytes()


@pytest.fixture
def folder(tmp_path, result):
    """Return a folder with a trap for each module, and what others have there."""
    folder, traces = tmp_path / "here", tmp_path / "traces"
    folder.mkdir()
    traces.mkdir()
    for name in NAMES:
        trap = f"open({str(traces / name)!r}, 'w').close()\nraise SystemExit(99)\n"
        (folder / f"{name}.py").write_text(trap)
    for name in ("tissuec", "multiprocessing", "numpy"):  # a package comes before a module
        (folder / name).mkdir()
        for part in ("__init__", "__main__"):
            trap = f"open({str(traces / f'{name}_{part}')!r}, 'w').close()\n"
            (folder / name / f"{part}.py").write_text(trap)
    (folder / "pair.tis").write_text(SCENE)
    (folder / "free.tis").write_text(re.sub(r"script \{.*?\n\}\n", "", PLAIN, flags=re.S))
    (folder / "data.csv").write_text(
        "t,f\n" + "".join(f"{n / 100},{n / 900}\n" for n in range(9))
    )
    (folder / "done.vtkhdf").write_bytes(result)
    return folder


def prepared(folder, outputs):
    """Make a link of each output, and put precious files beside them and behind links."""
    behind = folder.parent / "behind"
    behind.mkdir()
    for name in outputs:
        if name == "scene behind.tis":
            (folder / name).write_text(SCENE.replace("param pull", "param   pull"))
            (folder / "link.tis").symlink_to(name)
        else:
            (folder / name).symlink_to(behind / name)
        for other in (f"{name}.new", f"{name}~", f"{name}.tmp", f".{name}.new"):
            (folder / other).write_text("precious")
        (behind / "victim").write_text("precious")
        (folder / f"{name}.lock").symlink_to(behind / "victim")


def carried_out(folder, command):
    """Run a command as users do, from a shell."""
    words, outputs = COMMANDS[command]
    prepared(folder, outputs)
    before = content(folder.parent)
    started = "import sys; from tissuec.cli import main; main()"
    program = [sys.executable, "-P", "-c", started, *words]  # as the installed script
    done = subprocess.run(program, cwd=folder, capture_output=True, text=True, timeout=300)
    after = content(folder.parent)
    written = {f"behind/{name}" for name in outputs} | {"here/scene behind.tis"}
    lost = {name for name in before if after.get(name) != before[name]} - written
    return done, lost, after.keys() - before.keys() - written


def check(folder, command):
    done, lost, new = carried_out(folder, command)
    assert not list((folder.parent / "traces").iterdir()), done.stderr
    assert done.returncode in (0, 1), done.stderr
    assert "unknown" not in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert not lost, done.stderr
    assert not new, done.stderr
    for name in COMMANDS[command][1]:
        assert (folder / name).exists(), done.stderr


@pytest.mark.parametrize("command", SHORT)
def test_a_command_runs_and_loses_nothing_of_others(folder, command):
    check(folder, command)


@pytest.mark.slow
@pytest.mark.parametrize("command", sorted(COMMANDS.keys() - set(SHORT)))
def test_every_other_command_does_neither(folder, command):
    check(folder, command)
