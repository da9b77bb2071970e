"""A journaled file is an ordinary file whose states change all at once."""

import errno
import io
import subprocess
import sys

import numpy as np
import pytest

from tissuec.results.journal import PAGE, JournaledFile, has_journal


class Died(BaseException):
    """The process was killed."""


class MortalFile:
    """A raw file that fails after it has written so many bytes."""

    def __init__(self, raw, budget, failure):
        self.raw, self.budget, self.failure = raw, budget, failure

    def __getattr__(self, name):
        return getattr(self.raw, name)

    def write(self, data):
        if self.budget <= 0:
            raise self.failure
        count = self.raw.write(data[: min(self.budget, 1500)])
        self.budget -= count
        return count


def content(path):
    with JournaledFile(path, "read") as file:
        return file.read()


def random_change(random, file):
    """Seek somewhere and write something, or change the length."""
    size = file.seek(0, io.SEEK_END)
    if random.random() < 0.15:
        file.truncate(int(random.integers(0, size + 2 * PAGE)))
        return
    file.seek(int(random.integers(0, size + 100)))
    file.write(random.bytes(int(random.integers(1, 3 * PAGE))))


@pytest.mark.parametrize("seed", range(20))
def test_it_reads_and_writes_like_any_file(tmp_path, seed):
    path, other = tmp_path / "file", tmp_path / "plain"
    choices = [np.random.default_rng(seed), np.random.default_rng(seed)]
    with JournaledFile(path, "create") as file, open(other, "w+b", buffering=0) as plain:
        for step in range(60):
            for random, target in zip(choices, (file, plain), strict=True):
                random_change(random, target)
            size = plain.seek(0, io.SEEK_END)
            start, count = choices[0].integers(0, size + 10, size=2)
            choices[1].integers(0, size + 10, size=2)
            for target in (file, plain):
                target.seek(int(start))
            assert file.read(int(count)) == plain.read(int(count))
            if step % 7 == 3:
                file.commit()
                assert path.read_bytes() == other.read_bytes()


def prepared(path):
    """A file of several pages with a change of several runs that waits to be committed."""
    file = JournaledFile(path, "create")
    file.write(bytes(range(256)) * 100)
    file.commit()
    old = path.read_bytes()
    for place in (10, 3 * PAGE - 5, 5 * PAGE + 1):
        file.seek(place)
        file.write(b"new" * 20)
    file.seek(0, io.SEEK_END)
    file.write(b"tail" * 1000)
    file.seek(0)
    return file, old, file.read()


@pytest.mark.parametrize("budget", range(0, 40_000, 331))
def test_death_at_any_byte_of_a_commit_leaves_the_old_or_the_new_state(tmp_path, budget):
    path = tmp_path / "file"
    file, old, new = prepared(path)
    file._raw = MortalFile(file._raw, budget, Died())
    try:
        file.commit()
    except Died:
        if has_journal(path):
            assert content(path) == new
        else:  # nothing refers to what may stand behind the old state
            assert path.read_bytes()[: len(old)] == old
    else:
        assert path.read_bytes() == content(path) == new
        assert not has_journal(path)
    file._raw.close()
    with JournaledFile(path, "update") as again:  # going on applies the journal for good
        state = again.read()
        again.commit()
    assert path.read_bytes() == state


def test_there_are_deaths_before_and_after_the_journal(tmp_path):
    """The test above is empty if its budgets miss one of the two cases."""
    outcomes = set()
    for budget in (5000, 26_000):
        file, _, _ = prepared(tmp_path / "file")
        file._raw = MortalFile(file._raw, budget, Died())
        with pytest.raises(Died):
            file.commit()
        outcomes.add(has_journal(tmp_path / "file"))
        file._raw.close()
    assert outcomes == {False, True}


@pytest.mark.parametrize("budget", [0, 1000, 4000, 9000, 15_000])
def test_a_full_disk_leaves_the_old_state_and_another_commit_works(tmp_path, budget):
    path = tmp_path / "file"
    file, old, new = prepared(path)
    raw = file._raw
    file._raw = MortalFile(raw, budget, OSError(errno.ENOSPC, "No space left on device"))
    with pytest.raises(OSError, match="No space left"):
        file.commit()
    assert path.read_bytes() == old
    file._raw = raw
    file.commit()
    assert path.read_bytes() == new
    file.close()


def test_a_journal_with_a_wrong_bit_is_not_applied(tmp_path):
    path = tmp_path / "file"
    file, _, _ = prepared(path)
    file._raw = MortalFile(file._raw, 26_000, Died())
    with pytest.raises(Died):
        file.commit()
    file._raw.close()
    assert has_journal(path)
    data = bytearray(path.read_bytes())
    data[-500] ^= 1
    path.write_bytes(data)
    assert not has_journal(path)


def test_two_processes_cannot_write_one_file(tmp_path):
    pytest.importorskip("fcntl")
    path = tmp_path / "file"
    code = """if True:
        import pathlib, sys
        from tissuec.results.journal import JournaledFile
        try:
            JournaledFile(pathlib.Path(sys.argv[1]), "create")
        except BlockingIOError as error:
            print(error.strerror)
    """
    with JournaledFile(path, "create") as file:
        file.write(b"mine")
        file.commit()
        other = subprocess.run(
            [sys.executable, "-c", code, path], capture_output=True, text=True
        )
        assert other.stdout.strip() == "another process is writing it", other.stderr
        assert path.read_bytes() == b"mine"


@pytest.mark.parametrize("budget", [0, 1, 1500, 2 * PAGE, 4 * PAGE - 1])
def test_a_first_write_that_is_cut_short_begins_with_zeros(tmp_path, budget):
    """Nothing takes it for a whole file, however much of it is there."""
    path = tmp_path / "file"
    file = JournaledFile(path, "create")
    file.write(b"x" * (5 * PAGE))
    raw = file._raw
    file._raw = MortalFile(raw, budget, Died())
    with pytest.raises(Died):
        file.commit()
    raw.close()
    assert not any(path.read_bytes()[:PAGE])


def test_each_step_of_a_commit_waits_for_the_one_before_it(tmp_path, monkeypatch):
    """Data, journal and pages reach the disk in this order, each before the next is begun."""
    steps = []
    monkeypatch.setattr("os.fsync", lambda number: steps.append("sync"))
    file, *_ = prepared(tmp_path / "file")
    steps.clear()
    raw = file._raw

    class Watched(MortalFile):
        def write(self, data):
            place = self.raw.tell()
            kept = file._kept
            tail = kept + len(file._tail)
            steps.append("page" if place < kept else "data" if place < tail else "journal")
            return self.raw.write(data)

        def truncate(self, size):
            steps.append("cut")
            return self.raw.truncate(size)

    file._raw = Watched(raw, 0, None)
    file.commit()
    order = [step for step, former in zip(steps, ["", *steps], strict=False) if step != former]
    assert order == ["data", "sync", "journal", "sync", "page", "sync", "cut"]
