"""The progress line: what it says on a terminal, and that it is silent elsewhere."""

import io
import sys
import time

import pytest

from tissuec.compiled import loading
from tissuec.core import progress
from tissuec.core.progress import RunProgress, compiling
from tissuec.learn.fit.learning import LearnProgress
from tissuec.learn.report import Passes


class Terminal(io.StringIO):
    def isatty(self):
        return True


def impatient(monkeypatch, stream):
    """Let everything be shown at once, on a stream in the place of stderr."""
    monkeypatch.setattr(sys, "stderr", stream)
    for name, seconds in (("FIRST_AFTER", 0.0), ("EVERY", 0.01), ("SILENCE", 0.03)):
        monkeypatch.setattr(progress, name, seconds)
    return stream


def test_the_line_tells_the_time_and_goes_away(monkeypatch):
    terminal = impatient(monkeypatch, Terminal())
    with RunProgress("tube.tis", 2.0, shown=True, compiles=False) as line:
        line.at(0.5)
    assert "tube.tis [######  " in terminal.getvalue()
    assert "500 ms of 2 s" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[2K")


@pytest.mark.parametrize("name", ["tube.tis", "a/long/way/to/a/scene/of/sterilisation.tis"])
@pytest.mark.parametrize("columns", [40, 60, 80])
def test_the_line_does_not_wrap_and_tells_the_time_in_a_narrow_terminal(
    name, columns, monkeypatch
):
    monkeypatch.setenv("COLUMNS", str(columns))
    terminal = impatient(monkeypatch, Terminal())
    with RunProgress(name, 2.0, shown=True, compiles=False) as line:
        line.at(0.1)
        time.sleep(0.05)
        line.at(0.5)
    lines = terminal.getvalue().replace("\x1b[2K", "").split("\r")
    assert max(map(len, lines)) < columns
    assert any("500 ms of 2 s" in one and " left" in one for one in lines)


@pytest.mark.parametrize("shown", [True, False])
def test_a_learning_writes_lines_to_a_file_now_and_then(monkeypatch, shown):
    file = impatient(monkeypatch, io.StringIO())
    monkeypatch.setattr(progress, "LOGGED_EVERY", 0.05)
    with Passes("learn gum", shown=shown) as line:
        for number in (1, 2):
            for _ in range(3):
                line.at(LearnProgress(number, 10, 1.0, 3.0, 60.0, None, 5.0))
            time.sleep(0.06)
        line.at(LearnProgress(3, 10, 1.0, 3.0, 60.0, None, 5.0))
    lines = file.getvalue().splitlines()
    passes = [text.split(",")[0] for text in lines]
    expected = [f"learn gum: pass {number} of at most 10" for number in (2, 3)]
    assert passes == (expected if shown else [])


def until(condition, seconds):
    """Wait until something holds, but no longer than some time."""
    stop = time.monotonic() + seconds
    while not condition() and time.monotonic() < stop:
        time.sleep(0.01)


@pytest.mark.parametrize("compiles", [True, False])
def test_what_keeps_a_run_silent_is_said_when_kernels_are_compiled(monkeypatch, compiles):
    terminal = impatient(monkeypatch, Terminal())
    monkeypatch.setattr(loading, "translating", compiles)
    with RunProgress("tube.tis", 2.0, shown=True):
        until(lambda: "compiling" in terminal.getvalue(), 5.0 if compiles else 0.2)
    assert ("tube.tis: compiling kernels …" in terminal.getvalue()) is compiles


def test_what_comes_before_the_first_step_is_said(monkeypatch):
    terminal = impatient(monkeypatch, Terminal())
    with compiling("tube.tis", shown=True):
        until(lambda: "compiling" in terminal.getvalue(), 5.0)
    assert "tube.tis: compiling the scene …" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[2K")
    with RunProgress("tube.tis", 2.0, shown=True) as line:
        until(lambda: "preparing" in terminal.getvalue(), 5.0)
        line.at(0.0)
        said = terminal.getvalue().count("preparing")
        time.sleep(0.2)
    assert said and terminal.getvalue().count("preparing") == said


def test_the_check_after_the_last_step_is_said(monkeypatch):
    terminal = impatient(monkeypatch, Terminal())
    with RunProgress("tube.tis", 2.0, shown=True) as line:
        line.at(1.0)
        time.sleep(0.2)
        assert "checking the accuracy" not in terminal.getvalue()
        line.at(2.0)
        until(lambda: "checking" in terminal.getvalue(), 5.0)
    assert "tube.tis: simulated; checking the accuracy and" in terminal.getvalue()


def test_off_a_terminal_nothing_is_shown(monkeypatch):
    stream = impatient(monkeypatch, io.StringIO())
    with RunProgress("tube.tis", 2.0, shown=True) as line:
        line.at(0.5)
        time.sleep(0.2)
    assert stream.getvalue() == ""


def test_a_notebook_gets_blanks_where_a_terminal_is_told_to_clear(monkeypatch):
    stream = impatient(monkeypatch, io.StringIO())
    with RunProgress("tube.tis", 2.0, shown=True, compiles=False, anywhere=True) as line:
        line.at(0.5)
    last = stream.getvalue().split("\r")[-2]
    assert "500 ms of 2 s" in stream.getvalue() and "\x1b" not in stream.getvalue()
    assert last == " " * len(last) and len(last) > 40
