"""Nothing is lost: studies that are killed, interrupted, torn, or begun twice."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.study.scenes import SCENE, STUDY, carried_out, prepared
from tissuec.core.version import __version__
from tissuec.core.workers.processes import Processes
from tissuec.core.workers.workers import OwnProcess
from tissuec.engine.execution.companion import Companion
from tissuec.results import PlaceError
from tissuec.studies.journal import Journal
from tissuec.studies.study import run_study
from tissuec.studies.table_files import read_table

pytestmark = pytest.mark.usefixtures("interruptible")

SOME = ("vary lift = 2 mm to 9 mm in 6 steps",)  # times two tissues: 12 runs
MANY = ("vary lift = 2 mm to 9 mm in 20 steps",)  # 40 runs, which can be interrupted in time
COMMAND = (
    "import sys; sys.argv[0] = 'tissuec'\n"
    "from tissuec.cli import main\n"
    "main()\n"
)  # fmt: skip


def undisturbed(folder: Path, *entries: str, name: str = "table.csv") -> bytes:
    """Return the table of a study that nobody disturbs."""
    carried_out(*entries, out=folder / name)
    return (folder / name).read_bytes()


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> bytes:
    return undisturbed(tmp_path_factory.mktemp("whole"), *MANY)


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> bytes:
    return undisturbed(tmp_path_factory.mktemp("short"), *SOME)


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> bytes:
    return undisturbed(tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def plain_hdf5(tmp_path_factory) -> bytes:
    return undisturbed(tmp_path_factory.mktemp("plain"), name="table.h5")


class Killing:
    """Workers, one of which is killed after some rows."""

    def __init__(self, workers, after):
        self.workers, self.after, self.killed = workers, set(after), 0

    def map(self, *given):
        for number, found in enumerate(self.workers.map(*given)):
            if number in self.after:
                first = next(iter(self.workers._executor._workers))
                first.process.kill()
                self.killed += 1
            yield found

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self.workers.__exit__(*failure)


def begun(folder: Path, *more: str) -> subprocess.Popen:
    """Begin the study as a command, which writes table.csv in a folder."""
    (folder / "bar.tis").write_text(SCENE + STUDY, "utf-8")
    words = ["study", "bar.tis", "--vary", MANY[0][5:], "-o", "table.csv", *more]
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, *words], cwd=folder, stderr=subprocess.PIPE, text=True
    )


def count_of(table: Path) -> int:
    """Return how many lines of runs a file has at this moment."""
    return max(table.read_bytes().count(b"\n") - 2, 0) if table.exists() else 0


@pytest.mark.skipif(os.name == "nt", reason="kills by signals")
def test_killed_workers_leave_a_complete_table(tmp_path, short):
    workers = Killing(Processes(2), [3, 7])
    run_study(prepared(*SOME), workers, out=tmp_path / "table.csv")
    assert workers.killed == 2
    assert (tmp_path / "table.csv").read_bytes() == short


def test_processes_write_what_one_process_writes(tmp_path, short):
    run_study(prepared(*SOME), Processes(3), out=tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_bytes() == short


def interrupted_and_resumed(folder, whole, times, seed):
    """Interrupt a study at random moments, let it end at last, and compare."""
    chance, table, codes = random.Random(seed), folder / "table.csv", []
    for _ in range(times):
        # So many rows that most are still to come, however fast the machine is.
        enough = count_of(table) + chance.randint(1, 10)
        process = begun(folder, "--workers", chance.choice("12"))
        while process.poll() is None and count_of(table) < enough:
            time.sleep(0.002)
        number = chance.choice([signal.SIGINT, signal.SIGTERM])
        process.send_signal(number)
        said = process.communicate(timeout=60)[1]
        assert process.returncode in (0, 128 + number), said
        assert "Traceback" not in said
        codes.append(process.returncode)
        assert read_table(table) is not None  # at any moment
    process = begun(folder, "--workers", "2")
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 0, said
    assert any(code > 128 for code in codes)
    assert table.read_bytes() == whole
    assert sorted(path.name for path in folder.iterdir()) == ["bar.tis", "table.csv"]


@pytest.mark.skipif(os.name == "nt", reason="ends by signals")
@pytest.mark.parametrize(
    ("times", "seed"), [(1, 1), pytest.param(10, 2, marks=pytest.mark.slow)]
)
def test_interrupted_at_random_moments_the_same_command_goes_on(tmp_path, whole, times, seed):
    interrupted_and_resumed(tmp_path, whole, times, seed)


@pytest.mark.skipif(os.name == "nt", reason="ends by signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_interrupted_while_its_error_is_estimated_has_no_row(
    tmp_path, short, number, monkeypatch
):
    estimate, asked = Companion.estimate, []

    def interrupted(self, *given, **named):
        asked.append(self)
        if len(asked) == 3:
            os.kill(os.getpid(), number)
        return estimate(self, *given, **named)

    monkeypatch.setattr(Companion, "estimate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        carried_out(*SOME, out=tmp_path / "table.csv")
    assert count_of(tmp_path / "table.csv") == 2
    assert carried_out(*SOME, out=tmp_path / "table.csv").taken_over == 2
    assert (tmp_path / "table.csv").read_bytes() == short


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="ends by signals")
def test_interrupted_at_any_moment_at_all(tmp_path, whole):
    """Also while it starts, when Python itself may be what ends."""
    chance, table = random.Random(3), tmp_path / "table.csv"
    for _ in range(20):
        process = begun(tmp_path, "--workers", "2")
        time.sleep(1.5 * chance.random())
        process.send_signal(chance.choice([signal.SIGINT, signal.SIGTERM, signal.SIGKILL]))
        process.communicate(timeout=60)
        if table.exists() and table.stat().st_size:
            read_table(table)
    process = begun(tmp_path, "--workers", "2")
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 0, said
    assert table.read_bytes() == whole


@pytest.mark.parametrize("kept", [0, 1, 7, 11])
def test_rows_that_are_there_are_not_run_again(tmp_path, short, kept):
    path, lines = tmp_path / "table.csv", short.splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: 2 + kept]) + lines[2 + kept][:-9])  # a torn last row
    told = []
    found = carried_out(*SOME, out=path, progress=lambda *now: told.append(now))
    assert found.taken_over == kept and told[0] == (kept, 0, 12) and told[-1] == (12, 0, 12)
    assert path.read_bytes() == short


def test_a_row_that_is_torn_within_a_letter_is_done_again(tmp_path):
    text = (SCENE + STUDY).replace("measure pull", "measure größe")
    path = tmp_path / "table.csv"
    carried_out(text=text, out=path)
    whole, lines = path.read_bytes(), path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:4]) + "0,2,ö".encode()[:-1])
    assert carried_out(text=text, out=path).taken_over == 2
    assert path.read_bytes() == whole


def test_a_study_with_more_values_takes_over_what_it_has(tmp_path):
    path = tmp_path / "table.csv"
    carried_out("vary lift = [3 mm, 4 mm]", out=path)
    found = carried_out("vary lift = [2 mm, 4 mm, 3 mm]", out=path)
    assert found.taken_over == 4
    assert path.read_bytes() != b""
    fresh = carried_out("vary lift = [2 mm, 4 mm, 3 mm]", out=path, fresh=True)
    assert fresh.taken_over == 0
    assert [*fresh.table.column("lift").values] == [2, 2, 4, 4, 3, 3]


def test_runs_whose_worker_died_are_tried_again(tmp_path, short):
    path = tmp_path / "table.csv"
    path.write_bytes(short.replace(b",done,,kept", b",died,its worker process died,kept", 2))
    found = carried_out(*SOME, out=path)
    assert found.taken_over == 10 and path.read_bytes() == short


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("simulate { duration = 0.2 s", "simulate { duration = 0.3 s"),
            "6 runs .*another text",
        ),
        (("max(force of hand)", "min(force of hand)"), "6 runs .*another text"),
        (("2 mm to 6 mm in 3 steps", "2 mm to 4 mm in 2 steps"), "2 runs with other values"),
        (("study pulling", "study pushing"), "is the table of study pulling of bar"),
    ],
)
def test_a_table_of_something_else_is_kept(tmp_path, plain, change, message):
    path = tmp_path / "table.csv"
    path.write_bytes(plain)
    text = (SCENE + STUDY).replace(*change)
    with pytest.raises(PlaceError, match=rf"{message}.*-o other\.csv; --fresh"):
        carried_out(text=text, out=path)
    assert path.read_bytes() == plain
    assert carried_out(text=text, out=path, fresh=True).taken_over == 0
    assert path.read_bytes() != plain


def test_a_table_of_another_version_is_kept(tmp_path, plain, monkeypatch):
    from tissuec.studies import study

    path = tmp_path / "table.csv"
    path.write_bytes(plain)
    monkeypatch.setattr(study, "__version__", f"{__version__}.dev1")
    with pytest.raises(PlaceError, match=r"6 runs .*version of tissuec.*--fresh"):
        carried_out(out=path)


@pytest.mark.parametrize("fresh", [False, True])
def test_other_files_are_not_overwritten(tmp_path, fresh):
    path = tmp_path / "notes.csv"
    path.write_text("do not lose this\n", "utf-8")
    with pytest.raises(
        PlaceError, match=r"not a table of a study.*remove it, or write to another"
    ):
        carried_out(out=path, fresh=fresh)
    assert path.read_text("utf-8") == "do not lose this\n"


def test_hdf5_is_beside_the_rows(tmp_path, short):
    carried_out(*SOME, out=tmp_path / "table.h5")
    assert (tmp_path / "table.csv").read_bytes() == short
    assert read_table(tmp_path / "table.h5").is_complete


def test_a_table_in_hdf5_goes_on_without_the_rows_beside_it(tmp_path):
    carried_out("vary lift = [3 mm, 4 mm]", out=tmp_path / "table.h5")
    (tmp_path / "table.csv").unlink()
    found = carried_out("vary lift = [2 mm, 4 mm, 3 mm]", out=tmp_path / "table.h5")
    assert found.taken_over == 4
    carried_out("vary lift = [2 mm, 4 mm, 3 mm]", out=tmp_path / "other.csv")
    assert (tmp_path / "table.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("study pulling", "study pushing"), "is the table of study pulling of bar"),
        (("simulate { duration = 0.2 s", "simulate { duration = 0.3 s"), "6 runs .*another"),
    ],
)
def test_a_table_in_hdf5_of_something_else_is_kept(tmp_path, plain_hdf5, change, message):
    path, text = tmp_path / "table.h5", (SCENE + STUDY).replace(*change)
    path.write_bytes(plain_hdf5)
    with pytest.raises(PlaceError, match=rf"table\.h5.*{message}.*-o other\.h5; --fresh"):
        carried_out(text=text, out=path)
    assert path.read_bytes() == plain_hdf5 and not (tmp_path / "table.csv").exists()
    assert carried_out(text=text, out=path, fresh=True).taken_over == 0


@pytest.mark.parametrize("fresh", [False, True])
def test_other_files_in_hdf5_are_not_overwritten(tmp_path, fresh):
    import h5py

    path = tmp_path / "mine.h5"
    with h5py.File(path, "w") as file:
        file["data"] = [1.0, 2.0]
    before = path.read_bytes()
    with pytest.raises(
        PlaceError, match=r"not a table of a study; remove it, or .*-o other\.h5"
    ):
        carried_out(out=path, fresh=fresh)
    assert path.read_bytes() == before
    path.write_bytes(b"no HDF5 at all")
    with pytest.raises(PlaceError, match=r"remove it, or write to another"):
        carried_out(out=path, fresh=fresh)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no advisory locks")
def test_two_studies_do_not_write_one_table(tmp_path, whole):
    ready = prepared(*MANY)
    with Journal(tmp_path / "table.csv", ready.head, [], fresh=True):
        process = begun(tmp_path, "--fresh")
        said = process.communicate(timeout=60)[1]
        assert process.returncode == 2
        assert "another study is writing it; wait for its end, or write to another" in said
    process = begun(tmp_path)
    assert process.wait(timeout=60) == 0
    assert (tmp_path / "table.csv").read_bytes() == whole


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows has no advisory locks")
def test_of_studies_that_begin_together_one_goes_on(tmp_path, whole):
    for _ in range(5):
        processes = [begun(tmp_path, "--workers", "1") for _ in range(3)]
        codes = sorted(process.wait(timeout=60) for process in processes)
        assert codes[0] == 0 and set(codes) <= {0, 2}
        assert (tmp_path / "table.csv").read_bytes() == whole
        (tmp_path / "table.csv").unlink()


def test_results_need_a_place(tmp_path):
    with pytest.raises(PlaceError, match="give the table a place"):
        carried_out("keep is results")
    run_study(prepared("keep is results"), OwnProcess(), out=tmp_path / "table.csv")
    assert len(list((tmp_path / "table.runs").iterdir())) == 6
