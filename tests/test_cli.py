"""The command line: what it prints where, and its exit codes."""

import io
import json
import os
import shlex
import signal
import subprocess
import sys
import time
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

import click
import numpy as np
import pytest

from tests import test_docs
from tissuec.cli import common, run_guarded

# Found also in a checkout that was never installed.
ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parent.parent)}

OSCILLATOR = """language 1
param pull = 1 mm between 0 mm and 10 mm
tissue thread { spring constant = 100 N/m; viscosity = 0.1 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is thread }
table nodes of pair in mm with columns "id x y z" { 1 0 0 0; 2 10 0 0 }
table springs of pair with columns "a b" { 1 2 }
set left = nodes of pair in [1]
set right = nodes of pair in [2]
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix left
  from 0 s to 0.1 s: move right by (pull, 0 mm, 0 mm) using smooth profile
  at 0.1 s: release right
}
simulate { duration = 0.5 s; tolerance = 1e-6 }
output { trajectory every 50 ms; force of left every 10 ms; energy every 50 ms }
expect distance(left, right) between 10.99 mm and 11.01 mm at 0.1 s
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "pair.tis"
    path.write_text(OSCILLATOR)
    return path


def tissuec(*arguments, cwd):
    """Run a command line in this process: Python takes as long to start as most commands."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))
    with chdir(cwd), redirect_stdout(out), redirect_stderr(err):
        code = test_docs.tissuec(["tissuec", *map(str, arguments)])
    said = []
    for stream in (out, err):
        stream.flush()
        said.append(stream.buffer.getvalue().decode())
    return subprocess.CompletedProcess(arguments, code, *said)


def test_a_run_writes_its_result_into_the_present_folder(scene):
    run = tissuec("run", scene, cwd=scene.parent)
    assert run.returncode == 0, run.stderr
    assert (scene.parent / "pair.vtkhdf").exists()
    assert run.stdout == ""
    assert "expectations: 1 of 1 hold" in run.stderr


def test_quiet_says_nothing_and_json_is_one_document(scene):
    assert tissuec("-q", "run", scene, cwd=scene.parent).stderr == ""
    run = tissuec("run", scene, "--json", cwd=scene.parent)
    document = json.loads(run.stdout)
    assert document["ok"] and document["nodes"] == 2 and document["failures"] == []
    assert run.stderr == ""


@pytest.mark.parametrize("command", ["run", "check", "validate", "bench", "explain --plan"])
def test_warnings_are_shown_quietly_where_they_are_errors(scene, command):
    scene.write_text(OSCILLATOR.replace("set left", "param idle = 1 mm\nset left"))
    strictly = tissuec(*command.split(), scene, "-q", "--strict", cwd=scene.parent)
    assert strictly.returncode == 2
    assert "W501" in strictly.stderr and "error" not in strictly.stderr
    assert tissuec("check", scene, "-q", cwd=scene.parent).stderr == ""


@pytest.mark.parametrize("quiet", [(), ("-q",)])
def test_a_failed_expectation_exits_with_1_and_says_what_was_measured(scene, quiet):
    run = tissuec(*quiet, "run", scene, "--set", "pull=2 mm", cwd=scene.parent)
    assert run.returncode == 1
    assert "FAILED" in run.stderr and "distance(left, right) = 12 mm" in run.stderr


@pytest.mark.parametrize(
    ("text", "code"),
    [("pull=20 mm", "TIS308"), ("pull=2 N", "TIS502"), ("pul=2 mm", "TIS505"), ("pull", "TIS")],
)
def test_a_bad_set_exits_with_2(scene, text, code):
    run = tissuec("run", scene, "--set", text, cwd=scene.parent)
    assert run.returncode == 2
    assert code in run.stderr


def test_a_bad_text_exits_with_2_and_leaves_no_result(scene):
    scene.write_text(OSCILLATOR.replace("mesh is explicit", "mesh is explict"))
    run = tissuec("run", scene, cwd=scene.parent)
    assert run.returncode == 2
    assert "TIS305" in run.stderr and 'did you mean "explicit"' in run.stderr
    assert not (scene.parent / "pair.vtkhdf").exists()


def test_a_missing_file_exits_with_2_and_names_it(tmp_path):
    run = tissuec("run", "nowhere.tis", cwd=tmp_path)
    assert run.returncode == 2
    assert "nowhere.tis" in run.stderr and "Traceback" not in run.stderr


def test_a_diverging_run_exits_with_3_and_keeps_the_former_result(scene):
    assert tissuec("run", scene, cwd=scene.parent).returncode == 0
    before = (scene.parent / "pair.vtkhdf").read_bytes()
    wild = OSCILLATOR.replace("tolerance = 1e-6", "integrator is velocity verlet; step = 40 ms")
    late = wild.replace("11.01 mm at 0.1 s", "11.01 mm at 20 s")
    scene.write_text(late.replace("duration = 0.5 s", "duration = 50 s"))
    run = tissuec("run", scene, cwd=scene.parent)
    assert run.returncode == 3, run.stderr
    assert "pair.tis" in run.stderr
    assert "expectations: 0 of 1 hold, 1 not reached" in run.stderr
    assert (scene.parent / "pair.vtkhdf").read_bytes() == before
    quietly = tissuec("run", scene, "-q", cwd=scene.parent)
    assert quietly.returncode == 3
    assert "the motion grew without bounds" in quietly.stderr


def test_several_scenes_run_in_one_call_and_the_worst_exit_code_counts(scene):
    bad = scene.with_name("bad.tis")
    bad.write_text("language 1\nnonsense\n")
    run = tissuec("run", scene, bad, cwd=scene.parent)
    assert run.returncode == 2
    assert (scene.parent / "pair.vtkhdf").exists()


def test_one_output_name_for_two_scenes_is_refused(scene):
    run = tissuec("run", scene, scene, "-o", "x.vtkhdf", cwd=scene.parent)
    assert run.returncode == 2


def test_a_misspelt_command_is_suggested(tmp_path):
    run = tissuec("chekc", cwd=tmp_path)
    assert run.returncode == 2
    assert 'did you mean "check"' in run.stderr


def test_check_prints_diagnostics_as_json(scene):
    scene.write_text(OSCILLATOR.replace("100 N/m", "100 N"))
    run = tissuec("check", scene, "--json", cwd=scene.parent)
    document = json.loads(run.stdout)
    assert run.returncode == 2 and not document["ok"]
    (found,) = document["diagnostics"]
    assert (found["code"], found["line"]) == ("TIS502", 3)


def test_fmt_is_in_place_and_idempotent(scene):
    assert tissuec("fmt", scene, cwd=scene.parent).returncode == 0
    once = scene.read_text()
    assert tissuec("fmt", "--check", scene, cwd=scene.parent).returncode == 0
    assert scene.read_text() == once


def test_fmt_check_exits_with_1_and_changes_nothing(scene):
    scene.write_text(OSCILLATOR.replace("param pull", "param   pull"))
    before = scene.read_text()
    assert tissuec("fmt", "--check", scene, cwd=scene.parent).returncode == 1
    assert scene.read_text() == before


def test_export_and_info_read_what_a_run_wrote(scene):
    tissuec("run", scene, cwd=scene.parent)
    table = tissuec("export", "pair.vtkhdf", "force of left", cwd=scene.parent)
    head, *rows = table.stdout.splitlines()
    assert head.startswith("time [ms],force of left x [mN]")
    assert len(rows) == 51
    info = json.loads(tissuec("info", "pair.vtkhdf", "--json", cwd=scene.parent).stdout)
    assert info["finished"] and info["frames"]["count"] == 11
    for name in ("last.vtu", "last.obj"):
        assert tissuec("export", "pair.vtkhdf", "-o", name, cwd=scene.parent).returncode == 0
    assert "l 1 2" in (scene.parent / "last.obj").read_text()


def test_library_copy_puts_a_scene_beside_you_once(tmp_path):
    assert tissuec("library", "copy", "two_masses", cwd=tmp_path).returncode == 0
    assert tissuec("check", "two_masses.tis", cwd=tmp_path).returncode == 0
    again = tissuec("library", "copy", "two_masses", cwd=tmp_path)
    assert again.returncode == 2 and "--force" in again.stderr


def test_explain_names_rule_line_and_degree_of_each_quantity_of_the_tube(repository):
    run = tissuec("explain", "library/scenes/sterilisation.tis", "--json", cwd=repository)
    tissue = json.loads(run.stdout)["tissues"]["fallopian tube"]
    for quantity in ("spring constant", "viscosity", "mass", "breaking force"):
        (first, *_) = tissue["quantities"][quantity]["reasons"]
        assert 0.0 < first["degree"] <= 1.0
        assert first["place"].startswith("fuzzy/soft_tissue.tis:")
        assert first["facts"]


def test_a_reader_that_has_seen_enough_is_no_error(repository):
    read, write = os.pipe()
    os.close(read)
    scene = repository / "library/scenes/sterilisation.tis"
    command = [sys.executable, "-m", "tissuec", "explain", str(scene)]
    ended = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, env=ENVIRONMENT)
    os.close(write)
    assert (ended.returncode, ended.stderr) == (0, b"")


@pytest.mark.parametrize("width", [80, 120])
def test_explain_fits_the_terminal_and_loses_no_word(repository, monkeypatch, width):
    wide = tissuec("explain", "library/scenes/sterilisation.tis", cwd=repository).stdout
    monkeypatch.setattr(common, "line_width", lambda stream: width)
    narrow = tissuec("explain", "library/scenes/sterilisation.tis", cwd=repository).stdout
    assert narrow.split() == wide.split()
    assert max(map(len, narrow.splitlines())) <= width < max(map(len, wide.splitlines()))


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_scripts_are_printed(shell, tmp_path):
    run = tissuec("completion", shell, cwd=tmp_path)
    assert run.returncode == 0 and "_TISSUEC_COMPLETE" in run.stdout


@pytest.mark.skipif(os.name == "nt", reason="signals as on POSIX")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.usefixtures("interruptible")
def test_a_command_that_a_signal_ends_exits_with_128_and_its_number(name, capsys):
    number = signal.Signals[name]
    command = click.Command("wait", callback=lambda: os.kill(os.getpid(), number))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["tissuec"])
        assert run_guarded(command) == 128 + number
    assert "interrupted" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


LOADING = OSError("Could not find/load shared object file 'libllvmlite.so': cannot allocate")


@pytest.mark.parametrize("error", [MemoryError(), LOADING], ids=["anywhere", "while loading"])
def test_a_lack_of_memory_is_told_as_such(monkeypatch, capsys, error):
    def fail():
        raise error

    monkeypatch.setattr("sys.argv", ["tissuec"])
    assert run_guarded(click.Command("work", callback=fail)) == 3
    said = capsys.readouterr().err
    assert "there is not enough memory" in said and "report" not in said


def test_a_run_by_relaxation_tells_its_method(scene):
    timeless = "integrator is relaxation; step = 10 ms"
    scene.write_text(OSCILLATOR.replace("tolerance = 1e-6", timeless))
    run = tissuec("run", scene, cwd=scene.parent)
    assert "relaxation, " in run.stderr
    assert "tissuec itself failed" not in run.stderr


@pytest.mark.skipif(os.name == "nt", reason="signals as on POSIX")
def test_an_interrupted_run_exits_with_130_and_resumes_to_the_same_result(scene):
    h5py = pytest.importorskip("h5py")
    long = OSCILLATOR.replace(
        "duration = 0.5 s", "duration = 20000 s; integrator is dop853"
    ).replace(
        "trajectory every 50 ms; force of left every 10 ms; energy every 50 ms",
        "trajectory every 400 s",
    )
    scene.write_text(long)
    (scene.parent / "my library").mkdir()
    options = ["--companion", "off", "--set", "pull=0.999 mm", "--library", "my library"]
    command = [sys.executable, "-m", "tissuec", "run", str(scene), "--out", "broken"]
    process = subprocess.Popen(
        [*command, *options],
        cwd=scene.parent,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
        # Shells make background jobs ignore Ctrl-C, and what they start inherits that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    partial = scene.parent / "broken" / "pair.partial.vtkhdf"
    deadline = time.monotonic() + 60
    while not partial.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    refused = tissuec("run", scene, "--out", "broken", "--resume", cwd=scene.parent)
    assert refused.returncode == 2
    assert 'it was run with --set "pull=0.999 mm"; without --resume the' in refused.stderr
    (again,) = (line for line in said.splitlines() if "resume with: " in line)
    words = shlex.split(again.partition(": ")[2])
    assert words[:2] == ["tissuec", "run"] and words[-4:] == options[2:]
    resumed = tissuec(*words[1:], *options[:2], cwd=scene.parent)
    assert resumed.returncode == 0, resumed.stderr
    whole = tissuec("run", scene, "--out", "whole", *options, cwd=scene.parent)
    assert whole.returncode == 0, whole.stderr
    results = [
        h5py.File(scene.parent / folder / "pair.vtkhdf") for folder in ("broken", "whole")
    ]
    for name in ("VTKHDF/Points", "VTKHDF/Steps/Values", "VTKHDF/PointData/velocity"):
        assert np.array_equal(results[0][name][:], results[1][name][:])


def test_a_run_without_inertia_tells_its_method(tmp_path):
    (tmp_path / "pull.tis").write_text(
        """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 10 }
table springs of pair with columns "a b" { 1 2 }
set left = nodes of pair in [1]
environment { gravity = (0, 0, -1) m/s^2 }
script { at 0 s: fix left }
simulate { duration = 0.1 s; integrator is relaxation; step = 50 ms }
output { trajectory every 50 ms }
"""
    )
    done = tissuec("run", "pull.tis", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "; relaxation, " in done.stderr


def test_lines_break_between_words_at_the_edge_of_a_terminal():
    said = "  accuracy in time: 3.7e-07 of the largest displacement (tolerance 0.0001)"
    lines = common._wrapped(f"done\n\n{said}", 30).split("\n")
    assert lines[:2] == ["done", ""] and max(map(len, lines)) <= 30
    assert lines[2].startswith("  accuracy") and all(line[:4] == "    " for line in lines[3:])
    assert " ".join(" ".join(lines[2:]).split()) == said.strip()
