"""Files of one kind where another is expected: the answer says what to do with them."""

import pytest
from click.testing import CliRunner

from tests.every import every
from tissuec.cli import group
from tissuec.core.errors import CompileError
from tissuec.core.files import read_bytes
from tissuec.results import ResultError
from tissuec.results.trajectory import Trajectory
from tissuec.scene.program.imports import read_source


@pytest.mark.parametrize(
    ("name", "content", "remedy"),
    [
        ("run.vtkhdf", b"\x89HDF\r\n\x1a\n\x00", "tissuec view"),
        ("run.h5", b"\x89HDF\r\n\x1a\n\x00", "tissuec view"),
        ("liver.stl", b"solid liver\nendsolid liver\n", "tissuec import"),
        ("liver.VTU", b"<VTKFile/>", "tissuec import"),
    ],
)
def test_what_is_no_scene_is_told_with_the_command_for_it(tmp_path, name, content, remedy):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(CompileError) as failure:
        read_source(path)
    (found,) = failure.value.diagnostics
    assert found.code == "TIS604"
    assert f"{remedy} {path}" in found.hint


def test_a_scene_that_is_given_as_a_result_is_told_so(tmp_path):
    path = tmp_path / "scene.tis"
    path.write_text("language 1\n")
    with pytest.raises(ResultError, match="it is a scene; run it first: tissuec run"):
        Trajectory(path)


@pytest.mark.parametrize("wrong", ["rnu", "vew", "simulate"])
def test_an_unknown_command_is_answered_with_those_that_there_are(wrong):
    said = CliRunner().invoke(group, [wrong, "x"])
    assert said.exit_code == 2
    assert "commands: run, check" in said.output
    assert ("did you mean" in said.output) == (wrong != "simulate")


@every("name", ("a.tis", "a.stl", "a.inp", "a.nrrd", "a.vtkhdf", "a.csv"))
def test_a_pointer_of_git_lfs_is_named_as_such(name, tmp_path):
    path = tmp_path / name
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n")
    if name == "a.csv":
        with pytest.raises(OSError, match="pointer of Git LFS"):
            read_bytes(path, 1 << 20)
        return
    command = {".tis": "check", ".vtkhdf": "info"}.get(path.suffix, "import")
    said = CliRunner().invoke(group, [command, str(path)])
    found = f"{said.output}{said.exception}".lower()
    assert "it is a pointer of git lfs; to fetch the file itself" in found
