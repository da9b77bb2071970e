"""``import tissuec`` is light, and what it offers is there and typed."""

import shutil
import subprocess
import sys

import pytest

import tissuec


def test_the_import_brings_nothing_else_of_tissuec_and_no_library(repository):
    code = (
        "import sys; before = set(sys.modules); import tissuec; dir(tissuec)\n"
        "new = set(sys.modules) - before\n"
        "print(sorted(name for name in new if name.partition('.')[0] in "
        "('tissuec', 'numpy', 'scipy', 'h5py', 'numba', 'lark', 'click')))"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], cwd=repository, capture_output=True, text=True
    )
    assert said.stdout.strip() == "['tissuec']", said.stderr


def test_checking_and_compiling_bring_no_heavy_library(repository):
    code = (
        "import sys, tissuec\n"
        "assert tissuec.check('library/scenes/two_masses.tis') == []\n"
        "tissuec.compile('library/scenes/two_masses.tis')\n"
        "print([name for name in ('scipy', 'numba', 'h5py') if name in sys.modules])"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], cwd=repository, capture_output=True, text=True
    )
    assert said.stdout.strip() == "[]", said.stderr


def test_every_public_name_is_there_and_no_other_one():
    for name in tissuec.__all__:
        assert getattr(tissuec, name) is not None
    assert dir(tissuec) == sorted(tissuec.__all__)
    with pytest.raises(AttributeError, match='no attribute "simulate"'):
        tissuec.simulate  # noqa: B018  # pyright: ignore[reportAttributeAccessIssue]


def test_packages_that_use_it_are_told_that_it_is_typed(repository):
    assert (repository / "tissuec" / "py.typed").is_file()


@pytest.mark.slow
def test_a_type_checker_sees_what_is_imported_late(repository, tmp_path):
    pyright = shutil.which("pyright")
    if pyright is None:
        pytest.skip("pyright is not installed")
    (tmp_path / "user.py").write_text(
        "import tissuec\n"
        "trajectory = tissuec.run('a.tis', cut_time=0.9, strict=True)\n"
        "reveal_type(trajectory)\n"
        "reveal_type(trajectory.position[0])\n"
        "reveal_type(tissuec.check('a.tis')[0].message)\n"
        "reveal_type(tissuec.compile('a.tis').network.mass)\n"
        "tissuec.run(3)\n"
    )
    said = subprocess.run(
        [pyright, str(tmp_path / "user.py")], cwd=repository, capture_output=True, text=True
    ).stdout
    for kind in ('is "Trajectory"', 'is "str"', "dtype[floating[", "dtype[float64]"):
        assert kind in said, said
    assert "Unknown" not in said, said
    assert "1 error" in said, said
