"""A real browser for tests of pages: headless Chromium, drawing in software.

The fixture ``page`` is the tab (of the Python package playwright) with ``page.problems``: every
error or warning of the console, every uncaught exception, and every request that leaves the
machine. A test fails at its end if there are any. Tests skip where Chromium or playwright is
missing.
"""

import os
import shutil
from collections.abc import Iterator
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = (
    "--no-sandbox",  # containers run as root, which Chromium's sandbox refuses
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-gpu-compositing",  # only WebGL is left to the driver in software, which is slow
    "--disable-dev-shm-usage",
)
#: What the driver says because a test reads pixels back.
HARMLESS = ("GPU stall due to ReadPixels",)
LOCAL = ("file:", "data:", "blob:", "about:")
SIZE = {"width": 1280, "height": 800}


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium, started once."""
    playwright = pytest.importorskip("playwright.sync_api")
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"there is no {', '.join(NAMES)} to open pages with")
    with playwright.sync_playwright() as engine:
        chromium = engine.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def tab(browser: Any) -> Any:
    """A tab, which takes as long to open as a page takes to load."""
    context = browser.new_context(viewport=SIZE, reduced_motion="no-preference")
    tab = context.new_page()
    watch(tab)
    return tab


@pytest.fixture
def page(tab: Any) -> Iterator[Any]:
    """A tab as new that must stay without problems, without a network."""
    tab.problems.clear()
    yield tab
    problems = list(tab.problems)
    tab.goto("about:blank")
    tab.set_viewport_size(SIZE)
    tab.emulate_media(media="null", color_scheme="light", reduced_motion="no-preference")
    tab.context.clear_permissions()
    assert not problems, os.linesep.join(problems)


def watch(tab: Any) -> None:
    """Collect what goes wrong in a tab as ``tab.problems``."""
    tab.problems = []
    tab.on("console", lambda message: _console(tab, message))
    tab.on("pageerror", lambda error: tab.problems.append(f"exception: {error}"))
    tab.on("request", lambda request: _request(tab, request))


def _console(tab: Any, message: Any) -> None:
    is_harmless = any(text in message.text for text in HARMLESS)
    if message.type in ("error", "warning") and not is_harmless:
        tab.problems.append(f"{message.type}: {message.text}")


def _request(tab: Any, request: Any) -> None:
    if not request.url.startswith(LOCAL):
        tab.problems.append(f"request: {request.url}")
