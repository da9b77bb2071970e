"""The gallery shows every kind, by commands that can be typed."""

import re
import shlex

import pytest

from benchmarks.rivals.__main__ import main as rivals
from benchmarks.stability.__main__ import main as stability
from tissuec.cli import group
from tissuec.view.plots import PLOTS

#: What an option or a file says without --kind.
MEANT = {
    "--log": "logs", "--of": "paths", "--time": "frames", "tube.json": "work-precision",
    "stress.json": "stability", "liver.json": "stress-strain", "fuzzy/soft_tissue": "words",
    "sterilisation.vtkhdf": "overview", "displacement of pressed along z": "x-y",
    "--spectrum": "spectrum", "--envelope": "envelope",
}  # fmt: skip
BENCHMARKS = {"benchmarks.rivals": rivals, "benchmarks.stability": stability}
MOST = 1.2e6  # bytes of all pictures
SHELL = re.compile(r"^```sh\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def page(repository):
    return (repository / "docs" / "gallery.md").read_text(encoding="utf-8")


def lines(page):
    blocks = (block.replace("\\\n", "") for block in SHELL.findall(page))
    return [line for block in blocks for line in block.splitlines()]


def test_commands_can_be_typed(page):
    assert len(lines(page)) > 20
    for line in lines(page):
        program, name, *words = shlex.split(line.partition(" > ")[0])
        if [program, name] == ["python", "-m"]:
            name, *words = words
            one = BENCHMARKS[name]
        else:
            assert program == "tissuec"
            one = group.get_command(None, name)
        with one.make_context(name, words):  # or a wrong option is an error
            pass


def test_every_kind_is_shown(page):
    drawn = [line for line in lines(page) if line.startswith("tissuec plot")]
    said = {word for line in drawn for word in shlex.split(line)}
    shown = {kind for kind in PLOTS if kind in said}
    shown |= {kind for word, kind in MEANT.items() if word in said}
    assert shown == set(PLOTS)


def test_pictures_are_there_and_small(page, repository):
    names = re.findall(r"\((figures/gallery/\w+\.png)\)", page)
    assert len(names) == len(set(names)) == len(SHELL.findall(page))
    sizes = [(repository / "docs" / name).stat().st_size for name in names]
    kept = list((repository / "docs" / "figures" / "gallery").iterdir())
    assert len(kept) == len(names)  # none is left over
    assert sum(sizes) < MOST
