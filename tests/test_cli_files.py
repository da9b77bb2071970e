"""The command line and files: nothing is lost, and a name that is wrong is answered."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_cli import OSCILLATOR, tissuec
from tissuec import cli
from tissuec.cli import group

QUICK = OSCILLATOR.replace("duration = 0.5 s", "duration = 0.2 s")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "pair.tis"
    path.write_text(QUICK)
    return path


@pytest.fixture
def result(scene):
    run = tissuec("run", scene, cwd=scene.parent)
    assert run.returncode == 0, run.stderr
    return scene.with_suffix(".vtkhdf")


def refused(*arguments, cwd, code=2):
    """Return what a command line says that must be refused without a traceback."""
    done = tissuec(*arguments, cwd=cwd)
    assert done.returncode == code, done.stderr
    assert "itself failed" not in done.stderr and "Traceback" not in done.stderr
    return done.stderr


# --- nothing is written over ---


@pytest.mark.parametrize("link", [None, os.symlink, os.link])
def test_a_run_does_not_replace_its_scene(scene, link):
    output = scene
    if link is not None:
        output = scene.with_name("other.tis")
        link(scene, output)
    said = refused("run", "pair.tis", "-o", output.name, cwd=scene.parent)
    assert "is the input file" in said
    assert scene.read_text() == QUICK


def test_a_run_does_not_replace_its_scene_by_the_name_of_an_unfinished_result(scene):
    path = scene.rename(scene.with_name("pair.partial.tis"))
    assert "is the input file" in refused("run", path, "-o", "pair.tis", cwd=path.parent)
    assert path.read_text() == QUICK


def test_a_run_replaces_results_only(scene):
    notes = scene.with_name("notes.txt")
    notes.write_text("keep me")
    assert "a result is an HDF5 file" in refused(
        "run", scene, "-o", "notes.txt", cwd=scene.parent
    )
    kept = notes.rename(notes.with_suffix(".vtkhdf"))
    said = refused("run", scene, "-o", kept.name, cwd=scene.parent)
    assert "not a result of tissuec; give another file" in said
    assert kept.read_text() == "keep me"
    assert tissuec("run", scene, cwd=scene.parent).returncode == 0
    assert tissuec("run", scene, cwd=scene.parent).returncode == 0


def test_two_scenes_with_one_name_are_refused_before_anything_runs(scene):
    other = scene.parent / "sub" / "pair.tis"
    other.parent.mkdir()
    other.write_text(QUICK)
    said = refused("run", "pair.tis", "sub/pair.tis", cwd=scene.parent)
    assert '"pair.tis" and "sub/pair.tis" would both be "pair.vtkhdf"' in said
    assert not list(scene.parent.glob("*.vtkhdf"))


@pytest.mark.parametrize("link", [None, os.symlink, os.link])
def test_an_export_does_not_replace_its_result(result, link):
    output, before = result, result.read_bytes()
    if link is not None:
        output = result.with_name("other.vtkhdf")
        link(result, output)
    arguments = ("pair.vtkhdf", "--frame", "0", "--format", "vtu", "-o", output.name)
    assert "is the input file" in refused("export", *arguments, cwd=result.parent)
    assert result.read_bytes() == before


def test_an_export_of_what_is_not_there_leaves_files_alone(result):
    table = result.with_name("a.csv")
    table.write_text("keep me")
    refused("export", result, "forc of left", "-o", "a.csv", cwd=result.parent)
    assert table.read_text() == "keep me"


# --- places where nothing can be written ---


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "pair.tis", "--out", "pair.tis/sub"),
        ("run", "pair.tis", "--out", "x" * 300),
        ("library", "copy", "two_masses", "pair.tis/sub"),
    ],
)
def test_a_place_that_cannot_be_is_an_ordinary_error(scene, arguments):
    said = refused(*arguments, cwd=scene.parent)
    assert said.startswith("error: cannot ")


def test_fmt_where_nothing_can_be_written_is_an_ordinary_error(scene):
    """As in a folder that only others may write to; root may write to all."""
    scene.write_text(QUICK.replace("param pull", "param   pull"))
    code = """if True:
        import os, sys
        os_open = os.open
        def refuse(path, flags, *more, **named):
            if flags & os.O_CREAT:
                raise PermissionError(13, "Permission denied", os.fspath(path))
            return os_open(path, flags, *more, **named)
        os.open = refuse
        from tissuec.cli import main
        main()
    """
    for option in ([], ["--json"]):
        done = subprocess.run(
            [sys.executable, "-c", code, "fmt", *option, scene.name],
            cwd=scene.parent, capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 2
        said = json.loads(done.stdout)["error"] if option else done.stderr
        assert f'cannot write "{scene.name}": permission denied' in said


# --- names ---


@pytest.mark.parametrize("command", ["run", "check", "fmt", "explain", "validate", "bench"])
@pytest.mark.parametrize("name", ["pair", "piar.tis"])
def test_every_command_suggests_the_scene_that_was_meant(scene, command, name):
    said = refused(command, name, cwd=scene.parent)
    assert f'cannot read "{name}"' in said and 'did you mean "pair.tis"?' in said


def test_a_scene_in_another_folder_is_suggested_with_its_folder(scene):
    said = refused("fmt", f"{scene.parent.name}/pari.tis", cwd=scene.parent.parent)
    assert f'did you mean "{scene.parent.name}/pair.tis"?' in said


@pytest.mark.parametrize("name", ["./mywords", "mywords", "mywords.tis"])
def test_words_finds_a_vocabulary_as_use_does(tmp_path, repository, name):
    shipped = repository / "library" / "fuzzy" / "soft_tissue.tis"
    (tmp_path / "mywords.tis").write_text(shipped.read_text())
    words = tissuec("words", name, cwd=tmp_path)
    assert words.returncode == 0, words.stderr
    assert "property hardness" in words.stdout


def test_a_misspelt_vocabulary_is_suggested(tmp_path):
    said = refused("words", "fuzzy/soft_tisue", cwd=tmp_path)
    assert 'did you mean "fuzzy/soft_tissue"?' in said
    (tmp_path / "mywords.tis").touch()
    assert 'did you mean "mywords.tis"?' in refused("words", "./myword", cwd=tmp_path)


def test_info_of_a_folder_or_a_misspelt_result_says_so(result):
    (result.parent / "runs").mkdir()
    assert '"runs" is a folder' in refused("info", "runs", cwd=result.parent)
    assert 'did you mean "pair.vtkhdf"?' in refused("info", "pair", cwd=result.parent)


# --- what to export ---


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--frame", "3"], "-o names the file of a frame"),
        (["--time", "0.1"], "-o names the file of a frame"),
        (["--frame", "1", "--time", "0.1", "-o", "a.vtu"], "use one of them"),
        (["--frame", "1", "-o", "a.csv"], "is for .vtu, .obj, .ply and .vtm"),
        (["--all", "--frame", "1", "-o", "a.vtu"], "use one of them"),
        (["--all", "-o", "a.csv"], "is for .vtu, .obj, .ply and .vtm"),
        (["--surface", "pair"], "-o names the file of a frame"),
        (["--surface", "pair", "-o", "a.csv"], "not CSV"),
        (["--surface", "pair", "--time", "0", "-o", "a.vtkhdf"], "remove --time"),
        (["-o", "a.vtkhdf"], "needs --surface"),
        (["--format", "vtu", "-o", "-"], "-o names the file of a frame"),
        (["force of left", "-o", "a.vtu"], "VTU contains one frame, no logs"),
    ],
)
def test_options_of_export_that_would_be_ignored_are_refused(result, options, message):
    said = refused("export", result, *options, cwd=result.parent)
    assert message in " ".join(said.split())


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("trajectory every 50 ms", 'export "events" or a frame with -o frame.vtu'),
        ("energy every 50 ms", 'export "energies" or "events"'),
    ],
)
def test_a_result_without_logs_says_what_else_it_holds(scene, output, message):
    start = QUICK.index("trajectory every 50 ms;")
    stop = QUICK.index(" }\nexpect")
    scene.write_text(QUICK[:start] + output + QUICK[stop:])
    assert tissuec("run", scene, cwd=scene.parent).returncode == 0
    assert f"has no logs; {message}\n" in refused("export", "pair.vtkhdf", cwd=scene.parent)


# --- with --json there is one document on stdout, whatever happens ---


@pytest.mark.parametrize(
    "arguments",
    [
        ("info", "nowhere.vtkhdf"),
        ("library", "copy", "nowhere"),
        ("library", "nowhere"),
        ("chekc",),
        ("run", "--nonsense"),
        ("run", "nowhere.tis"),
        ("fmt", "nowhere.tis"),
        ("check", "nowhere.tis"),
        ("export", "nowhere.vtkhdf", "--frame", "1"),
    ],
)
def test_an_error_is_a_document_too(tmp_path, arguments):
    done = tissuec(*arguments, "--json", cwd=tmp_path)
    document = json.loads(done.stdout)
    assert done.returncode == 2 and not document["ok"]
    assert document.get("error") or document["diagnostics"]
    assert done.stderr == ""


@pytest.mark.parametrize(
    "arguments",
    [("library",), ("library", "list"), ("library", "copy", "skin"), ("completion", "bash")],
)
@pytest.mark.parametrize("place", [0, 1, 2, 3])
def test_global_options_go_before_or_behind_every_name(tmp_path, arguments, place):
    words = list(arguments)
    words.insert(place, "--json")
    done = tissuec(*words, "-q", "--no-color", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) and done.stderr == ""


def test_an_export_as_json_holds_tables_or_says_where_they_are(result):
    def exported(*arguments):
        done = tissuec("export", result, *arguments, "--json", cwd=result.parent)
        assert done.returncode == 0 and done.stderr == ""
        return json.loads(done.stdout)

    table = exported()["force of left"]
    assert table["columns"] == ["x", "y", "z"] and table["unit"] == "N"
    assert len(table["time"]) == len(table["value"]) == 21
    assert set(exported("energies", "events")) == {"energies", "events"}
    assert exported("energies", "-o", "a.csv")["file"] == "a.csv"
    assert exported("--time", "0.1", "-o", "a.obj") == {
        "ok": True,
        "file": "a.obj",
        "frame": 2,
        "time": 0.1,
    }
    assert Path(result.parent, "a.obj").exists()


# --- smooth surfaces ---

TUBE = """language 1
tissue gum { spring constant = 20 N/m; viscosity = 20 mN*s/m; mass = 10 mg }
body vessel {
  mesh is tube { axis from (0, 0, 0) mm to (9, 0, 0) mm; radius = 3 mm; rings = 4; sides = 8 }
  tissue is gum
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 30 ms }
output { trajectory every 30 ms; surface of vessel every 10 ms { subdivisions = 1 } }
"""


@pytest.fixture
def tube(tmp_path):
    (tmp_path / "tube.tis").write_text(TUBE)
    run = tissuec("run", "tube.tis", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert run.stderr.endswith("  surface of vessel: tube.vessel.vtkhdf\n")
    return tmp_path


def test_a_surface_is_exported_at_a_time_at_all_times_and_as_one_file(tube):
    def told(*options):
        done = tissuec("export", "tube.vtkhdf", "--surface", "Vessel", *options, cwd=tube)
        assert done.returncode == 0, done.stderr
        return done.stderr

    assert "frame 2 (t = 0.02 s)" in told("--time", "0.019", "-o", "a.ply")
    assert (tube / "a.ply").read_bytes().startswith(b"ply\nformat binary_little_endian 1.0\n")
    assert "frame 3 (t = 0.03 s)" in told("-o", "a.obj")
    assert (tube / "a.obj").read_text().count("\nv ") == 7 * 16
    assert told("--all", "-o", "b.vtu") == "wrote 4 frames to b_0000.vtu … b_0003.vtu\n"
    assert len(list(tube.glob("b_*.vtu"))) == 4
    assert told("-o", "c.vtkhdf") == "wrote 4 frames to c.vtkhdf\n"
    document = json.loads(told_json(tube, "--all", "-o", "d.obj"))
    assert document.pop("ok") is True
    assert document == {"files": ["d_0000.obj", "d_0001.obj"]}  # of the net, which has two
    told("--all", "-o", "e.obj")
    assert (tube / "e_0003.obj").read_bytes() == (tube / "a.obj").read_bytes()


def told_json(folder, *options):
    return tissuec("export", "tube.vtkhdf", *options, "--json", cwd=folder).stdout


def test_a_surface_that_is_not_there_is_answered_with_those_that_are(tube, result):
    said = refused("export", "tube.vtkhdf", "--surface", "vesel", "-o", "a.ply", cwd=tube)
    assert 'has no surface of "vesel"; did you mean "vessel"?' in said
    said = refused("export", "pair.vtkhdf", "--surface", "pair", "-o", "a.ply", cwd=tube)
    assert "write output { surface of pair every 40 ms } and run the scene again" in said
    said = refused("info", "tube.vessel.vtkhdf", cwd=tube)
    assert (
        'is the ParaView file for the surface of vessel in "tube.vtkhdf"; use that file' in said
    )
    assert not (tube / "a.ply").exists()


def test_a_view_in_the_way_is_found_before_anything_runs(tube):
    place = tube / "tube.vessel.vtkhdf"
    place.write_text("keep me")
    said = refused("run", "tube.tis", cwd=tube)
    assert "for the surface of vessel: it exists" in said
    assert place.read_text() == "keep me"


def test_fmt_as_json_is_one_document(scene):
    scene.write_text(QUICK.replace("param pull", "param   pull"))
    done = tissuec("fmt", "--diff", scene, "--json", cwd=scene.parent)
    document = json.loads(done.stdout)
    assert document["changed"] == [str(scene)] and "+param pull" in document["printed"]


def test_a_file_with_a_command_says_in_its_first_line_what_help_lists():
    files = sorted(Path(cli.__file__).parent.glob("*.py"))
    commands = {path.stem for path in files if "\ndef command(" in path.read_text("utf-8")}
    assert commands == {*group.list_commands(None), *cli.HIDDEN}
    assert group.list_commands(None)[0] == "run"


TIMES = [
    (name, option)
    for name in group.list_commands(None)
    for option in group.get_command(None, name).params
    if {"--time", "--every"} & set(option.opts) and not option.is_flag
]


@pytest.mark.parametrize(("name", "option"), TIMES, ids=lambda one: getattr(one, "name", one))
@pytest.mark.parametrize("text", ["0.8 s", "0.8s", "800 ms", "0.8"])
def test_times_on_the_command_line_may_have_any_unit_of_time(name, option, text):
    assert option.type.convert(text, option, None) == pytest.approx(0.8)
