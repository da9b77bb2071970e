"""What is shipped is of these sources, and is loaded however the cache may be."""

import ctypes
import re
import shutil

import pytest

from tissuec.compiled import loading, sources
from tissuec.compiled.bundles import BUNDLES
from tissuec.compiled.loading import ENDING, INDEX, SHIPPED, called_by, machine_code
from tissuec.compiled.sources import SOURCES, digest_of_sources
from tissuec.core import cache
from tissuec.core.resources import PACKAGE
from tissuec.engine.codegen.contents import bundles

MODULE = """
define double @twice(double %x) {
  %y = fadd double %x, %x
  ret double %y
}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder of the cache, empty at first."""
    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    return tmp_path / "kernels"


def twice():
    code = machine_code("twice", MODULE.encode(), lambda: MODULE)
    function = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)
    return function(code.get_function_address("twice"))(21.0)


def test_what_is_shipped_is_made_of_these_sources():
    assert loading.index()["sources"] == digest_of_sources(), (
        "run: python -m tissuec.engine.codegen"
    )


def test_comments_and_docstrings_are_no_part_of_the_digest(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "PACKAGE", tmp_path)
    (tmp_path / "kernels").mkdir()

    def digest(text):
        (tmp_path / "kernels" / "one.py").write_text(text)
        return digest_of_sources()

    plain = digest("def twice(x):\n    return 2 * x\n")
    assert (
        digest('"""One."""\n\ndef twice(x):  # why\n    """Two."""\n    return (2 * x)\n')
        == plain
    )
    assert digest("def twice(x):\n    return 2.0 * x\n") != plain
    assert digest('def twice(x):\n    x = "no docstring"\n    return 2 * x\n') != plain


def test_sources_are_complete():
    # What the loop over steps calls of other modules of its folder is shipped with it.
    for source in (PACKAGE / "engine").glob("step_*.py"):
        if f"engine/{source.name}" in SOURCES:
            called = re.findall(r"^from tissuec\.engine\.(step_\w+)", source.read_text(), re.M)
            assert {f"engine/{name}.py" for name in called} <= {*SOURCES}


def test_every_operation_every_method_and_every_field_is_shipped():
    names = {path.name.removesuffix(ENDING) for path in SHIPPED.glob(f"*{ENDING}")}
    assert names == {*bundles(), "team"} and names >= {
        *BUNDLES,
        "drive_dop853",
        "field_foundation",
    }
    assert all("force" in called_by(name) for name in names if name.startswith("drive_"))
    assert INDEX.is_file()


def test_machine_code_is_kept_and_found_again(folder):
    assert twice() == 42.0
    (kept,) = folder.iterdir()
    before = kept.stat().st_mtime_ns
    assert twice() == 42.0
    assert kept.stat().st_mtime_ns == before


@pytest.mark.parametrize("damage", [b"", b"too short", bytes(5000)])
def test_damaged_machine_code_is_made_anew(folder, damage):
    twice()
    (kept,) = folder.iterdir()
    good = kept.read_bytes()
    kept.write_bytes(damage)
    assert twice() == 42.0
    assert kept.read_bytes() == good


def test_it_does_without_a_cache(folder, monkeypatch):
    monkeypatch.setattr(cache, "cache_folder", lambda: None)
    assert twice() == 42.0
    folder.write_text("in the way")
    monkeypatch.setattr(cache, "cache_folder", lambda: folder.parent)
    assert twice() == 42.0
    assert not shutil.rmtree(folder, ignore_errors=True)
