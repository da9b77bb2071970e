"""What is written appears as a whole, follows no foreign link, and has one writer at a time."""

import ast
import errno
import gc
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import tissuec
from tests.modules import nodes, trees
from tests.test_cli import OSCILLATOR
from tests.test_cli import tissuec as command
from tissuec.core.files import OutputFile, final_place, replacing, write_file
from tissuec.results import PlaceError

POSIX = pytest.mark.skipif(os.name == "nt", reason="links and permissions as on POSIX")
SCENE = OSCILLATOR.replace("duration = 0.5 s", "duration = 0.2 s")
STUDY = """study pulls {
  vary pull = 0.5 mm to 1.5 mm in 3 steps
  measure far = max(force of left)
}
"""
#: Files that a command writes, beside those of `tissuec.core.files`: none of a user's.
OWN = {
    "core/files.py",
    "engine/codegen/contents.py",  # the kernels in the repository
    "engine/execution/companion.py",  # a folder that was just made
    "lang/parse_table.py",  # the table in the repository
    "results/trajectory.py",  # a folder that was just made
}


#: Of those, what is no file of its own: bytes, and the file that a store has open.
NO_FILE = ("np.savez(content", "open(os.devnull", "open_file(self._disk")


def test_everything_is_written_through_one_door():
    """By functions of `core.files`, or into the file that `replacing` yields."""
    found = []
    for path in sorted(trees().keys() - OWN):
        for call in (one for one in nodes(path) if isinstance(one, ast.Call)):
            text, name = ast.unparse(call), ast.unparse(call.func).split(".")[-1]
            writes = name in ("write_text", "write_bytes", "savez", "copyfile")
            opens = name in ("open", "open_file", "FileIO") and re.search("'[wax]b?\\+?'", text)
            if (writes or opens) and not re.search("beside|_disk|self._path", text):
                found.append(f"{path}: {text}")
    assert not [one for one in found if not any(word in one for word in NO_FILE)]


# --- replacing --------------------------------------------------------------------------------


def test_nothing_that_stands_beside_an_output_is_touched(tmp_path):
    path = tmp_path / "page.html"
    path.with_name("page.html.new").write_text("precious")
    write_file(path, "one")
    write_file(path, b"two")
    assert path.read_text() == "two"
    assert path.with_name("page.html.new").read_text() == "precious"
    assert sorted(one.name for one in tmp_path.iterdir()) == ["page.html", "page.html.new"]


@POSIX
def test_a_link_stays_a_link_and_the_file_behind_it_is_written(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "real").write_text("old")
    (tmp_path / "middle").symlink_to("data/real")
    (tmp_path / "link").symlink_to("middle")
    write_file(tmp_path / "link", "new")
    assert os.readlink(tmp_path / "link") == "middle"
    assert os.readlink(tmp_path / "middle") == "data/real"
    assert (tmp_path / "data" / "real").read_text() == "new"
    (tmp_path / "other").symlink_to("data/none")  # a link to what is not there yet
    write_file(tmp_path / "other", "made")
    assert (tmp_path / "data" / "none").read_text() == "made"


@POSIX
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755, 0o444])
def test_the_permissions_of_a_file_stay(tmp_path, mode):
    path = tmp_path / "file"
    path.write_text("old")
    path.chmod(mode)
    write_file(path, "new")
    assert path.stat().st_mode & 0o777 == mode


@POSIX
def test_a_new_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").write_text("")
    write_file(tmp_path / "file", "new")
    assert (tmp_path / "file").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_a_failure_leaves_the_former_file_and_nothing_else(tmp_path):
    path = tmp_path / "file"
    path.write_text("old")

    def fail():
        with replacing(path) as beside:
            beside.write_text("half")
            raise OSError(errno.ENOSPC, "No space left on device", str(beside))

    with pytest.raises(OSError, match="No space left") as found:
        fail()
    assert found.value.filename == str(path)  # and not the name beside it
    assert path.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


@POSIX
def test_a_pipe_is_written_to_and_not_replaced(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    read = []
    thread = threading.Thread(target=lambda: read.append(path.read_text()))
    thread.start()
    write_file(path, "through it")
    thread.join()
    assert read == ["through it"] and path.is_fifo()


@POSIX
def test_a_link_that_leads_to_itself_is_an_error(tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OSError, match="symbolic links"):
        write_file(tmp_path / "loop", "text")
    assert (tmp_path / "loop").is_symlink()


# --- one writer -------------------------------------------------------------------------------


def test_a_file_has_one_writer_in_this_process(tmp_path):
    path = tmp_path / "file"
    with OutputFile(path, "append") as file:
        file.write(b"mine")
        for mode in ("append", "update", "create"):
            with pytest.raises(BlockingIOError, match="written already"):
                OutputFile(path, mode)
        path.read_bytes()  # which would let go of a lock of the whole process
        with pytest.raises(BlockingIOError):
            OutputFile(path, "append")
    with OutputFile(path, "append") as file:
        assert file.read() == b"mine"
    OutputFile(path, "append")  # forgotten, and closed by that
    gc.collect()
    OutputFile(path, "create").close()
    assert path.read_bytes() == b""


@POSIX
def test_a_reader_of_this_process_does_not_let_others_write(tmp_path):
    path = tmp_path / "file"
    code = (
        "import sys, pathlib; from tissuec.core.files import OutputFile;"
        "OutputFile(pathlib.Path(sys.argv[1]), 'append')"
    )
    with OutputFile(path, "append"):
        path.read_bytes()
        run = [sys.executable, "-c", code, str(path)]
        other = subprocess.run(run, capture_output=True, text=True)
    held = "F_OFD_SETLK" in dir(__import__("fcntl"))
    assert ("BlockingIOError" in other.stderr) == held


@POSIX
@pytest.mark.parametrize("mode", ["append", "update", "create"])
def test_a_growing_file_is_never_opened_through_a_link(tmp_path, mode):
    (tmp_path / "victim").write_text("precious")
    (tmp_path / "link").symlink_to("victim")
    with pytest.raises(OSError, match="it is a link; remove it"):
        OutputFile(tmp_path / "link", mode)
    assert (tmp_path / "victim").read_text() == "precious"


def test_a_file_that_is_replaced_stays_with_its_writer(tmp_path):
    path = tmp_path / "file"
    file = OutputFile(path, "append")
    file.write(b"first")
    file = file.replaced(b"second")
    assert path.read_bytes() == b"second"
    with pytest.raises(BlockingIOError):
        OutputFile(path, "append")
    file.write(b" and more")
    file.close_as(tmp_path / "final")
    assert (tmp_path / "final").read_bytes() == b"second and more" and not path.exists()
    OutputFile(tmp_path / "final", "update").close()


def test_an_empty_file_that_is_released_is_gone(tmp_path):
    OutputFile(tmp_path / "file", "append").release()
    assert not list(tmp_path.iterdir())
    file = OutputFile(tmp_path / "file", "append")
    file.write(b"x")
    file.release()
    file.release()
    assert (tmp_path / "file").read_bytes() == b"x"


# --- results, runs and tables -----------------------------------------------------------------


def together(count, action):
    """Call a function in threads at once; return what each call returned or raised."""
    barrier, found = threading.Barrier(count), [None] * count

    def call(number):
        barrier.wait()
        try:
            found[number] = action(number)
        except Exception as error:
            found[number] = error

    threads = [threading.Thread(target=call, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return found


def test_runs_in_threads_do_not_share_a_result(tmp_path):
    out = tmp_path / "same.vtkhdf"

    def run(number):
        with tissuec.run(
            SCENE, out=out, pull=f"{number + 1} mm", strict=False, companion="off"
        ) as result:
            return result.manifest["overrides"]

    found = together(3, run)
    refused = [one for one in found if isinstance(one, PlaceError)]
    done = [one for one in found if not isinstance(one, Exception)]
    assert len(refused) + len(done) == 3 and done, found
    assert all("another run is writing it" in str(one) for one in refused)
    with tissuec.load(out) as result:
        assert result.finished and result.manifest["overrides"] in done
    assert [one.name for one in tmp_path.iterdir()] == ["same.vtkhdf"]


def test_studies_in_threads_do_not_share_a_table(tmp_path):
    out = tmp_path / "same.csv"
    found = together(2, lambda _: len(tissuec.study(SCENE + STUDY, out=out, workers=1)))
    refused = [one for one in found if isinstance(one, PlaceError)]
    assert all("another study is writing it" in str(one) for one in refused)
    assert sorted(map(str, found)) == sorted([*map(str, refused), *["3"] * (2 - len(refused))])
    assert len(tissuec.read_table(out)) == 3


def test_the_result_of_a_stepped_run_is_nobody_elses(tmp_path):
    out = tmp_path / "one.vtkhdf"
    first = tissuec.start(SCENE, out=out)
    for other in (tissuec.start, tissuec.run):
        with pytest.raises(PlaceError, match="another run is writing it; wait for its end"):
            other(SCENE, out=out)
    first.step("60 ms")
    first.close()
    first.close()
    assert [one.name for one in tmp_path.iterdir()] == ["one.vtkhdf"]
    with tissuec.load(out) as result:
        assert result.times[-1] == 0.06
    second = tissuec.start(SCENE, out=out)
    del second  # without a result
    gc.collect()
    assert [one.name for one in tmp_path.iterdir()] == ["one.vtkhdf"]
    tissuec.start(SCENE, out=out).close()


def test_a_stepped_run_does_not_begin_where_its_result_would_replace_another_file(tmp_path):
    (tmp_path / "notes.vtkhdf").write_text("keep me")
    with pytest.raises(PlaceError, match="not a result of tissuec"):
        tissuec.start(SCENE, out=tmp_path / "notes.vtkhdf")
    assert (tmp_path / "notes.vtkhdf").read_text() == "keep me"


@POSIX
def test_a_run_to_a_link_writes_the_file_behind_it(tmp_path):
    (tmp_path / "disk").mkdir()
    link = tmp_path / "out.vtkhdf"
    link.symlink_to("disk/real.vtkhdf")
    for _ in range(2):
        with tissuec.run(SCENE, out=link, companion="off") as result:
            assert result.finished
    assert os.readlink(link) == "disk/real.vtkhdf"
    assert [one.name for one in (tmp_path / "disk").iterdir()] == ["real.vtkhdf"]
    assert final_place(link) == tmp_path / "disk" / "real.vtkhdf"


@POSIX
def test_an_unfinished_result_is_not_written_through_a_link(tmp_path):
    with tissuec.run(SCENE, out=tmp_path / "precious.vtkhdf", companion="off"):
        pass
    before = (tmp_path / "precious.vtkhdf").read_bytes()
    (tmp_path / "out.partial.vtkhdf").symlink_to("precious.vtkhdf")
    with pytest.raises(PlaceError, match="it is a link; remove it"):
        tissuec.run(SCENE, out=tmp_path / "out.vtkhdf", companion="off")
    assert (tmp_path / "precious.vtkhdf").read_bytes() == before


@POSIX
def test_a_table_behind_a_link_is_written_and_taken_over(tmp_path):
    (tmp_path / "table.csv").symlink_to("real.csv")
    first = tissuec.study(SCENE + STUDY, out=tmp_path / "table.csv", workers=1)
    before = (tmp_path / "real.csv").read_bytes()
    tissuec.study(SCENE + STUDY, out=tmp_path / "table.csv", workers=1)
    assert (tmp_path / "real.csv").read_bytes() == before and len(first) == 3
    assert os.readlink(tmp_path / "table.csv") == "real.csv"


@POSIX
def test_fmt_formats_the_file_behind_a_link(tmp_path):
    (tmp_path / "real.tis").write_text(SCENE.replace("param pull", "param    pull"))
    (tmp_path / "real.tis.new").write_text("precious")
    (tmp_path / "link.tis").symlink_to("real.tis")
    assert command("fmt", "link.tis", cwd=tmp_path).returncode == 0
    assert (tmp_path / "link.tis").is_symlink()
    assert "param pull" in (tmp_path / "real.tis").read_text()
    assert (tmp_path / "real.tis.new").read_text() == "precious"
    assert len(list(Path(tmp_path).iterdir())) == 3
