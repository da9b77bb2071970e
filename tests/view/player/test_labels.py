"""Numbers beside axes of the page: told apart, and with room for all of their letters."""

import json
import shutil
import subprocess

import pytest

from tests.every import every
from tissuec.core.scale import scale_of
from tissuec.view.player.page import WEB, units_of

LETTER = 6.0  # [px]: of the stub of a canvas
#: A chart on a stub of the page: texts that are written, from where to where.
CHART = """
const texts = [];
const pen = new Proxy({
  measureText: (text) => ({ width: LETTER * text.length }),
  fillText(text, x) {
    const width = LETTER * text.length;
    const left = x - { right: width, center: width / 2, left: 0 }[this.textAlign || "left"];
    texts.push([text, left, left + width]);
  },
}, { get: (held, name) => held[name] ?? (() => {}) });
const canvas = { getContext: () => pen };
globalThis.window = { devicePixelRatio: 1 };
const chart = Object.assign(Object.create(Chart.prototype), {
  canvas, left: 44, divisor: given.divisor,
  curve: { low: given.low, high: given.high, columns: [], time: given.range, empty: false },
  plot: { clientWidth: given.width, clientHeight: 120 },
  figure: { querySelectorAll: () => [] },
  player: { range: given.range, clock: { divisor: 1 }, film: { marks: [] } },
});
chart.draw({ muted: "", grid: "" });
return texts;
"""


def evaluated(lines, given, scripts=("units.js", "curves.js")):
    """Return what lines return after scripts that need no page, with ``given``."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    code = "".join((WEB / name).read_text(encoding="utf-8") for name in scripts)
    function = json.dumps(f'"use strict"; const LETTER = {LETTER};\n{code}\n{lines}')
    program = (
        'const given = JSON.parse(require("fs").readFileSync(0, "utf8"));'
        f'process.stdout.write(JSON.stringify(new Function("given", {function})(given)));'
    )
    run = subprocess.run(
        [node, "-e", program], input=json.dumps(given), capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


RANGES = [
    (6.66e-4, 6.662e-4), (666.0, 666.2), (0.0, 1.0), (-5.0, 5.0), (1e-6, 3e-6), (-2e-5, 2e-5),
    (1e7, 1.0001e7), (-99_999.5, 99_999.5), (10.0, 10.01),
]  # fmt: skip


@every(("low", "high"), RANGES)
def test_numbers_at_an_axis_are_told_apart_and_are_what_they_say(low, high):
    places, texts = evaluated(
        "const found = ticks(given[0], given[1], 4); return [found, apart(found)];", [low, high]
    )
    assert len(set(texts)) == len(texts) >= 2
    read = [float(text.replace("−", "-")) for text in texts]
    assert read == pytest.approx(places, abs=1e-6 * (high - low))


@every(("low", "high"), RANGES)
def test_numbers_at_the_axes_of_a_chart_are_not_cut_off(low, high):
    given = {"low": low, "high": high, "divisor": 1, "range": [0.0, 12_000.0], "width": 300}
    texts = evaluated(CHART, given)
    assert len(texts) >= 4
    assert min(left for _, left, _ in texts) >= 0.0
    assert max(right for *_, right in texts) <= 300.0


@pytest.mark.parametrize("unit", ["m", "N"])
def test_lengths_and_forces_have_the_units_of_axes(unit):
    sizes = [number * 10.0**power for power in range(-11, 7) for number in (1.0, 3.2, 9.9996)]
    found = evaluated(
        "return given.sizes.map((size) => scaled(size, given.units)[1]);",
        {"sizes": [0.0, *sizes], "units": units_of(unit)},
    )
    assert found == [scale_of(unit, [size]).unit for size in (0.0, *sizes)]
