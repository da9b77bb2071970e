"""The scripts of the page without the page: run by node, or by Chromium where there is none."""

import json
import shutil
import subprocess
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import pytest

PLAIN = ("inference.js", "numbers.js", "stress.js")  # what needs no page
INFER = """
const system = prepare(given.tables);
return given.cases.map(({ rules, facts }) => {
  const base = system.bases.get(rules);
  const { verdicts, answers } = infer(system, base, new Map(Object.entries(facts)));
  return {
    degrees: verdicts.map(({ degree }) => degree),
    answers: Object.fromEntries([...answers].map(([key, { source, value }]) => [key, {
      source, value, reason: source === "none" ? reasonOf(base, key, verdicts) : "",
    }])),
  };
});
"""


@pytest.fixture(scope="session")
def script(request: pytest.FixtureRequest) -> Callable[[str, Any], Any]:
    """A function that runs lines after the plain scripts, with ``given``; returns a result."""
    node = shutil.which("node")
    if node is not None:
        return lambda lines, given: _by_node(node, lines, given)
    browser = request.getfixturevalue("browser")  # skips with a reason
    return lambda lines, given: _by_browser(browser, lines, given)


def code() -> str:
    """Return the plain scripts."""
    folder = files("tissuec.view.explorer")
    return "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in PLAIN)


def _by_node(node: str, lines: str, given: Any) -> Any:
    function = json.dumps(f'"use strict";{code()}\n{lines}')
    program = (
        'const given = JSON.parse(require("fs").readFileSync(0, "utf8"));'
        f'const result = new Function("given", {function})(given);'
        "process.stdout.write(JSON.stringify(result));"
    )
    # By stdin, because what stands in an argument of a command is limited.
    command = [node, "-e", program]
    run = subprocess.run(command, input=json.dumps(given), capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def _by_browser(browser: Any, lines: str, given: Any) -> Any:
    tab = browser.new_page()
    try:
        return tab.evaluate(f'(given) => {{ "use strict"; {code()}\n{lines} }}', given)
    finally:
        tab.close()
