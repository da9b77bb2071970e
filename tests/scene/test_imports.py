"""Files that use one another: which of several is taken, and what is said about the others."""

import shutil
from pathlib import Path

import pytest

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.resources import library
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

SCENE = """language 1
use "fuzzy/soft_tissue"
use "tissues/fallopian_tube"
body vessel {
  mesh is tube {
    axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 5; sides = 10
    interior is crossed
  }
  tissue is fallopian tube
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """Return a scene in a folder that holds a copy of the library, as a checkout does."""
    shutil.copytree(library(), tmp_path / "library")
    path = tmp_path / "tube.tis"
    path.write_text(SCENE)
    return path


def warnings_of(path: Path) -> tuple[Diagnostic, ...]:
    return check_request(Request.file(path))[1]


def test_a_copy_of_the_library_beside_a_scene_is_used_in_silence(scene: Path) -> None:
    assert not warnings_of(scene)


def test_a_changed_copy_is_told_of_once_for_each_file_it_hides(scene: Path) -> None:
    mine = scene.parent / "library" / "tissues" / "fallopian_tube.tis"
    mine.write_text(mine.read_text() + "# of my own\n")
    (warning,) = warnings_of(scene)
    assert warning.code == "W601"
    shipped = library() / "tissues" / "fallopian_tube.tis"
    assert warning.message == f'"{mine}" hides {shipped}'


def test_a_changed_vocabulary_beside_the_shipped_one_is_still_a_second_one(scene: Path) -> None:
    mine = scene.parent / "library" / "fuzzy" / "soft_tissue.tis"
    mine.write_text(mine.read_text() + "# of my own\n")
    with pytest.raises(CompileError) as caught:
        warnings_of(scene)
    assert caught.value.diagnostics[0].code == "TIS503"


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("tissues/matter/liver", "matter/liver"),
        ("library/tissues/liver", "tissues/liver"),
        ("liver", "tissues/liver"),
        ("two_masses", None),  # a scene, which no other text can use
    ],
)
def test_a_file_in_the_wrong_folder_is_found(
    tmp_path: Path, written: str, meant: str | None
) -> None:
    path = tmp_path / "tube.tis"
    path.write_text(SCENE.replace("tissues/fallopian_tube", written))
    with pytest.raises(CompileError) as caught:
        warnings_of(path)
    hint = caught.value.diagnostics[0].hint
    assert (f'"{meant}"' in hint) if meant else "scenes/" not in hint
