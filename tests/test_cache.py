"""What is kept in the cache runs as code: nobody else's is taken, and it does not grow."""

import os

import pytest

from tissuec.core import keeping

POSIX = pytest.mark.skipif(os.name == "nt", reason="owners and links as on POSIX")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(keeping, "cache_folder", lambda: tmp_path)
    return tmp_path


def made(content=b"made"):
    return lambda: content


def test_what_is_made_once_is_kept(folder):
    assert keeping.recalled("kernels/a.o", made()) == b"made"
    assert keeping.recalled("kernels/a.o", made(b"again")) == b"made"
    assert [one.name for one in (folder / "kernels").iterdir()] == ["a.o"]


@POSIX
def test_it_is_kept_for_this_user_alone_whatever_the_mask(folder):
    before = os.umask(0o002)
    try:
        keeping.recalled("a.o", made())
    finally:
        os.umask(before)
    assert (folder / "a.o").stat().st_mode & 0o777 == 0o600


@POSIX
@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_what_others_may_have_written_is_made_anew(folder, mode):
    keeping.recalled("a.o", made(b"theirs"))
    (folder / "a.o").chmod(mode)
    assert keeping.recalled("a.o", made()) == b"made"
    assert keeping.recalled("a.o", made(b"again")) == b"made"  # private from now on


@POSIX
def test_what_another_user_owns_is_made_anew(folder, monkeypatch):
    keeping.recalled("a.o", made(b"theirs"))
    monkeypatch.setattr(os, "getuid", lambda: (folder / "a.o").stat().st_uid + 1)
    assert keeping.recalled("a.o", made()) == b"made"


@POSIX
def test_a_link_is_not_followed(folder):
    keeping.recalled("theirs.o", made(b"theirs"))
    (folder / "a.o").symlink_to("theirs.o")
    assert keeping.recalled("a.o", made()) == b"made"


@POSIX
def test_a_pipe_is_not_waited_for(folder):
    os.mkfifo(folder / "a.o")
    assert keeping.recalled("a.o", made()) == b"made"


@POSIX
def test_a_folder_that_is_a_link_is_not_used(tmp_path, monkeypatch):
    real, link = tmp_path / "real", tmp_path / "caches" / "tissuec"
    real.mkdir(mode=0o700)
    link.parent.mkdir()
    link.symlink_to(real)
    monkeypatch.setenv("XDG_CACHE_HOME", str(link.parent))
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_, **__: link)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    assert keeping.cache_folder.__wrapped__() == tmp_path / f"tissuec-cache-{os.getuid()}"


def test_what_was_not_used_for_the_longest_time_goes(folder, monkeypatch):
    """As with formulas that have other numbers in each run."""
    monkeypatch.setattr(keeping, "MOST", 10)
    for number in range(10):
        keeping.recalled(f"kernels/{number}.o", made())
        os.utime(folder / "kernels" / f"{number}.o", (number, number))
    left = folder / "kernels" / "left by a kill"
    left.mkdir()
    os.utime(left, (0, 0))
    keeping.recalled("kernels/new.o", made())
    kept = {one.name for one in (folder / "kernels").iterdir()}
    assert kept == {"6.o", "7.o", "8.o", "9.o", "new.o"}
