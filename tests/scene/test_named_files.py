"""What a text names is read only if it is a regular file of its folders, and not too large."""

import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest

from tissuec.core import files
from tissuec.core.errors import CompileError
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes as on POSIX")
#: A scene, in which one line after the other names a file.
SCENE = """language 1
{use}
tissue skin {{ spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 0.2 g }}
body sheet {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 3; rows = 3
  }}
  tissue is skin
}}
{body}
set left = nodes of sheet where x < 1 mm
set right = nodes of sheet where x > 19 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{
  at 0 s: {{ fix left; hold right }}
  {script}
}}
simulate {{ duration = 10 ms }}
{learn}
"""
NAMES = {
    "use": ("words.tis", 'use "./words"', "language 1\n"),
    "body": (
        "organ.stl",
        'body organ { mesh is imported { file "organ.stl" in mm }; tissue is skin }',
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\n"
        "endloop\nendfacet\nendsolid a\n",
    ),
    "script": (
        "path.csv",
        'from 0 s to 5 ms: move right along table "path.csv" in mm',
        "0,0,0,0\n0.005,1,0,0\n",
    ),
    "learn": (
        "data.csv",
        'learn skin { data = "data.csv"; adjust = [spring constant]; write "out.tis"\n'
        '  fit = force(right along (1, 0, 0)) using column "f" in mN }',
        "t_s,f\n0,0\n0.001,1\n",
    ),
}


def prepare(folder: Path, kind: str) -> tuple[Request, Path, str]:
    """Write a scene that names a file; return it, where the file goes, and its content."""
    name, line, content = NAMES[kind]
    parts = dict.fromkeys(NAMES, "") | {kind: line}
    scene = folder / "scene.tis"
    scene.write_text(SCENE.format(**parts))
    return Request.file(scene), folder / name, content


def refusal(request: Request) -> str:
    with pytest.raises(CompileError) as failure:
        check_request(request)
    (found,) = failure.value.diagnostics[:1]
    return found.code


@pytest.mark.parametrize("kind", NAMES)
def test_a_regular_file_is_read(tmp_path, kind):
    request, place, content = prepare(tmp_path, kind)
    place.write_text(content)
    check_request(request)


@pytest.mark.parametrize("kind", NAMES)
def test_a_pipe_is_refused_without_waiting_for_its_writer(tmp_path, kind):
    _, place, _ = prepare(tmp_path, kind)
    os.mkfifo(place)
    command = [sys.executable, "-m", "tissuec", "check", str(tmp_path / "scene.tis")]
    checked = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert checked.returncode == 2, checked.stdout
    assert "TIS60" in checked.stderr + checked.stdout


@pytest.mark.parametrize("kind", NAMES)
def test_a_link_to_a_device_is_refused(tmp_path, kind):
    request, place, _ = prepare(tmp_path, kind)
    place.symlink_to("/dev/zero")
    assert refusal(request).startswith("TIS60")


@pytest.mark.parametrize("kind", NAMES)
def test_a_link_out_of_the_folders_is_refused_unless_a_library_allows_it(tmp_path, kind):
    inner, outer = tmp_path / "inner", tmp_path / "outer"
    inner.mkdir(), outer.mkdir()
    request, place, content = prepare(inner, kind)
    (outer / "file").write_text(content)
    place.symlink_to(outer / "file")
    assert refusal(request) == "TIS603"
    check_request(Request(request.source, libraries=(outer,)))


@pytest.mark.parametrize("kind", NAMES)
def test_links_within_the_folder_and_to_the_folder_are_followed(tmp_path, kind):
    inner = tmp_path / "inner"
    inner.mkdir()
    _, place, content = prepare(inner, kind)
    (inner / "other").write_text(content)
    place.symlink_to("other")
    (tmp_path / "link").symlink_to(inner)
    check_request(Request.file(tmp_path / "link" / "scene.tis"))


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # takes no room on the disk
    with pytest.raises(OSError, match="larger than 1 MiB"):
        files.read_bytes(path, 1 << 20)


def test_a_pipe_that_a_user_names_is_read_up_to_the_limit(tmp_path):
    with pytest.raises(OSError, match="larger than 1 MiB"):
        files.read_bytes(Path("/dev/zero"), 1 << 20, regular=False)


def test_a_small_file_needs_little_memory(tmp_path):
    path = tmp_path / "small"
    path.write_bytes(b"x" * 1000)
    tracemalloc.start()
    files.read_bytes(path, 1 << 28, regular=False)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1 << 20
