"""What is shipped is of these sources, and is loaded however the cache may be."""

import ctypes
import re
import shutil
import sys
from pathlib import Path

import pytest

from tissuec.compiled import loading, sources
from tissuec.compiled.binding import Binder
from tissuec.compiled.bundles import BUNDLES
from tissuec.compiled.loading import ENDING, INDEX, SHIPPED, called_by, machine_code
from tissuec.compiled.sources import SOURCES, digest_of_sources
from tissuec.core import keeping
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
    monkeypatch.setattr(keeping, "cache_folder", lambda: tmp_path)
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
    known = {path for pattern in SOURCES for path in PACKAGE.glob(pattern)}
    for part in (part for parts in bundles().values() for part in parts):
        binder = Binder({"share": None} | part.replaced)
        binder.bind(part.function)
        for function in binder.copied:
            assert Path(function.__code__.co_filename) in known, function
        # Constants of other modules count, too.
        modules = {sys.modules[function.__module__] for function in binder.copied}
        for module in modules:
            text = Path(module.__file__).read_text(encoding="utf-8")
            for name in re.findall(r"^from tissuec\.(geometry\.\w+|forces\.\w+) ", text, re.M):
                assert PACKAGE / f"{name.replace('.', '/')}.py" in known, (module, name)


def test_every_operation_every_method_and_every_field_is_shipped():
    names = {path.name.removesuffix(ENDING) for path in SHIPPED.glob(f"*{ENDING}")}
    assert names == {*bundles(), "team"} and names >= {
        *BUNDLES,
        "drive_dop853",
        "field_jets",
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
    monkeypatch.setattr(keeping, "cache_folder", lambda: None)
    assert twice() == 42.0
    folder.write_text("in the way")
    monkeypatch.setattr(keeping, "cache_folder", lambda: folder.parent)
    assert twice() == 42.0
    assert not shutil.rmtree(folder, ignore_errors=True)
