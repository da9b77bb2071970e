"""Whatever files and things are called, messages, pages and pictures can be shown."""

import json
import os
import re
import sys

import pytest

from tests.test_cli import tissuec
from tissuec.core.data import printable
from tissuec.core.errors import CompileError, Diagnostic, TissueError, render
from tissuec.core.source import Source, Span

SCENE = """language 1
tissue skin { spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 10 g }
body rope { mesh is explicit; tissue is skin }
table nodes of rope in mm with columns "id x" { 0 0; 1 10; 2 20 }
table springs of rope with columns "a b" { 0 1; 1 2 }
environment { gravity = (0, 0, -9.81) m/s^2 }
simulate { duration = 5 ms }
output { trajectory every 1 ms; energy every 1 ms }
"""
#: No UTF-8, colours and titles of a terminal, formulas, the direction of writing.
NAMES = {
    "latin": os.fsdecode(b"caf\xe9"),
    "escape": "a\x1b[31m\x1b]0;x\x07\x9b2J",
    "formula": r"a$x^$\frac b",
    "direction": "a\u202ecod",
}
ODD = re.compile("[\x00-\x08\x0b-\x0c\x0e-\x1f\x7f-\x9f\u202e\ud800-\udfff]")


def said(folder, *words):
    """Return the exit code of a command and all that it has printed."""
    run = tissuec(*words, cwd=folder)  # by streams that take strict UTF-8 only
    return run.returncode, run.stdout + run.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="others restrict names of files")
def test_every_command_takes_a_file_of_any_name(tmp_path):
    pytest.importorskip("matplotlib")
    name = "".join(NAMES.values())
    (tmp_path / f"{name}.tis").write_text(SCENE)
    result = f"{name}.vtkhdf"
    for words in (
        ("run", f"{name}.tis"),
        ("info", result),
        ("info", result, "--json"),
        ("plot", result, "-o", "plot.svg"),
        ("view", result, "-o", "page.html"),
        ("view", result, "--png", "still.png"),
        ("report", result, "-o", f"{name}.html"),
        ("compare", result, result),
    ):
        code, text = said(tmp_path, *words)
        assert code == 0, text
        assert not ODD.search(text), text
    for words in (("check", f"no{name}.tis"), ("info", f"no{name}"), (f"no{name}",)):
        code, text = said(tmp_path, *words)
        assert code == 2 and not ODD.search(text), text
        assert "no" + printable(name) in text


@pytest.mark.parametrize("name", NAMES.values())
def test_messages_in_python_can_be_shown(name):
    source = Source(name, "language 1\n")
    finding = Diagnostic("TIS100", name, Span(source, 0, 8), name)
    for text in (render(finding), str(CompileError([finding])), str(TissueError(name))):
        assert printable(name) in text and not ODD.search(text)
        text.encode("utf-8")


def test_what_is_made_printable_stays_json_and_keeps_letters():
    text = 'Ünïcødé "λ"\n\t日本 👩‍🔬 \u200c'
    assert printable(text) == text
    odd = {NAMES["escape"]: NAMES["latin"]}
    assert json.loads(printable(json.dumps(odd, ensure_ascii=False)))
