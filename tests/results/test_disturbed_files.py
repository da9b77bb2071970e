"""Another program changes the unfinished result of a run: an error says so, Python lives."""

import subprocess
import sys

import pytest

from tissuec.results import ResultError
from tissuec.results.journal import JournaledFile

SCENE = """\
language 1
use "tissues/muscle"
body b {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (9, 0, 0) mm; second edge = (0, 9, 0) mm
    columns = 9; rows = 9; diagonals is both
  }
  tissue is muscle
}
environment { gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m }
simulate { duration = 40 ms }
output { trajectory every 1 ms; energy every 1 ms }
"""

#: Runs a scene once for each way to disturb it, and prints how it ended.
SCRIPT = """
import gc, os, sys
from pathlib import Path
import tissuec
from tissuec.results import writer

writer._LONGEST_WAIT = 0.0  # flush after each row
WAYS = {
    "overwritten": lambda path: path.write_bytes(b"nonsense"),
    "emptied": lambda path: path.write_bytes(b""),
    "halved": lambda path: os.truncate(path, path.stat().st_size // 2),
    "removed": lambda path: path.unlink(),
    "replaced": lambda path: (path.unlink(), path.write_bytes(b"another file")),
}
for name, disturb in WAYS.items():
    folder = Path(sys.argv[1]) / name
    folder.mkdir()
    seen = []

    def progress(_):
        seen.append(1)
        if len(seen) == 2:
            disturb(folder / "a.partial.vtkhdf")

    try:
        out = folder / "a.vtkhdf"
        run = tissuec.run(sys.argv[2], out=out, progress=progress, companion="off")
        print(name, len(run.times), sorted(path.name for path in folder.iterdir()))
        del run
    except Exception as error:
        print(name, type(error).__name__, str(error).replace(str(folder), ""))
        del error
    gc.collect()
print("alive")
"""


def test_a_disturbed_result_is_an_error_or_is_written_again(tmp_path):
    found = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", SCRIPT, str(tmp_path), SCENE],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr[-2000:]  # -11 if Python dies
    *lines, last = found.stdout.splitlines()
    assert last == "alive"
    cut = 'ResultError cannot write "/a.partial.vtkhdf": '
    for line, way in zip(lines[:3], ("overwritten", "emptied", "halved"), strict=True):
        assert line.startswith(f"{way} {cut}")
        assert line.endswith("another program has cut it")
    assert lines[3] == "removed 41 ['a.vtkhdf']"
    assert lines[4] == "replaced 41 ['a.partial.vtkhdf', 'a.vtkhdf']"
    other = tmp_path / "replaced" / "a.partial.vtkhdf"
    assert other.read_bytes() == b"another file"


def test_a_writer_hears_of_lost_bytes_at_its_commit(tmp_path):
    """HDF5 itself must not meet an error: Python does not survive that."""
    path = tmp_path / "file"
    with JournaledFile(path, "create") as file:
        file.write(bytes(range(200)) * 100)
        file.commit()
        with path.open("r+b") as other:
            other.truncate(5000)
        file.seek(10_000)
        assert file.read(100) == bytes(100)
        file.seek(12_000)
        assert file.write(b"changed") == 7
        with pytest.raises(OSError, match=r"ends before byte \d+: another program has cut it"):
            file.commit()
    # Whoever only reads is told at once.
    with JournaledFile(path, "read") as file:
        file.truncate(9000)
        file._kept = 9000
        file.seek(4990)
        with pytest.raises(OSError, match="another program has cut it"):
            file.read(100)


def test_a_result_is_not_renamed_if_its_folder_is_gone(tmp_path):
    import shutil

    from tissuec.results.store import Store

    folder = tmp_path / "folder"
    folder.mkdir()
    store = Store(folder / "a.partial.vtkhdf", "create")
    shutil.rmtree(folder)
    with pytest.raises((OSError, ResultError)):
        store.close(folder / "a.vtkhdf")
