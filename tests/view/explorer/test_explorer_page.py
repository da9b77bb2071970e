"""The page in a browser: what is set by hand leads to what ``tissuec explain`` says."""

import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from tests.view.explorer.vocabularies import of_file, vocabulary
from tissuec.cli import group
from tissuec.compiler.provenance import shown_value
from tissuec.core.names import key_of
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.core.units import STIFFNESS, parse_unit, show
from tissuec.fuzzy.hedges import hedged
from tissuec.fuzzy.rulebase import Inference
from tissuec.pipeline import read_words
from tissuec.scene.request import Request
from tissuec.scene.words.phrases import reading
from tissuec.view.explorer.page import document, render

SHIPPED = [
    path
    for path in sorted(library().glob("fuzzy/*.tis"))
    if "\nrules " in path.read_text(encoding="utf-8")
]
ALIKE = 1e-9  # relative: exp, log and erfc differ in their last digits
#: Sets properties by hand, case by case, and tells what the page then shows.
BY_HAND = """cases => cases.map((settings) => {
  for (const [key, how, what, hedge] of settings) {
    const box = document.querySelector(`.property[data-key="${CSS.escape(key)}"]`);
    const told = box.querySelector("input[type=checkbox]");
    const fire = (element, kind) => element.dispatchEvent(new Event(kind, { bubbles: true }));
    if (how === "unsaid") { if (told.checked) told.click(); continue; }
    if (how === "slider") {
      const slider = box.querySelector("input[type=range]");
      slider.value = what;
      fire(slider, "input");
    } else if (how === "number") {
      const field = box.querySelector(".number");
      field.value = what;
      fire(field, "input");
      fire(field, "change");
    } else {
      box.querySelectorAll(".ticks button")[what].click();
      const choice = box.querySelector("select");
      const option = [...choice.options].find((one) => one.value === hedge && !one.disabled);
      if (hedge && option) { choice.value = hedge; fire(choice, "change"); }
    }
  }
  const rows = [...document.querySelectorAll("#sentences li")];
  return {
    state: JSON.parse(document.querySelector("#state").value),
    text: document.querySelector("#text").textContent,
    degrees: rows.map((row) => Number(row.dataset.degree)),
    values: Object.fromEntries([...document.querySelectorAll(".quantity")].map((box) => [
      box.dataset.key, { source: box.dataset.source, value: box.querySelector(".value").value,
        told: box.querySelector(".told").textContent }])),
  };
})"""


def opened(page: Any, path: Path, folder: Path) -> Any:
    """Open the page of a vocabulary from a file."""
    target = folder / "page.html"
    target.write_text(render(document(Request.file(path))), encoding="utf-8")
    page.goto(target.as_uri())
    return page


def settings(one: Any, rules: str, count: int, seed: int) -> Iterator[list[list[Any]]]:
    """Yield what to set: sliders anywhere, numbers at ends and corners, words with hedges."""
    source = random.Random(seed)
    properties, hedges = one.words.vocabulary.properties, ["", *one.words.vocabulary.hedges]
    tables = {row["key"]: row for row in one.tables["properties"]}
    base = one.words.vocabulary.rules[rules].base
    for number in range(count):
        case: list[list[Any]] = []
        for key, named in properties.items():
            axis, row = named.scale.axis, tables[key]
            how = source.choice(["slider", "slider", "number", "word", "word"])
            how = "unsaid" if source.random() < 0.03 else how
            what: Any = source.choice([0, 1, source.random(), source.random()])
            if number < 2:  # everything at either end
                how, what = "slider", number
            elif how == "number":
                places = [*base._corners[key], *axis.bounds]
                place = min(max(source.choice(places), axis.bounds[0]), axis.bounds[1])
                what = f"{axis.from_scale(place) / row['factor']!r} {row['unit']}".strip()
            elif how == "word":
                what = source.randrange(len(row["words"]))
            case.append([key, how, what, source.choice(hedges)])
        yield case


def value_of(one: Any, key: str, fact: str) -> float:
    """Return what a fact of the state stands for, read here and not in the page."""
    named = one.words.vocabulary.properties[key]
    axis, words, hedges = named.scale.axis, named.scale.words, one.words.vocabulary.hedges
    sign, _, text = fact.partition(" ")
    if sign == "=":
        number, _, unit = text.partition(" ")
        return float(number) * (parse_unit(unit).factor if unit else 1.0)
    front, word = reading(text.replace('"', ""), words, hedges)
    return axis.value_of(hedged([hedges[name] for name in front], words[word], axis))


def assert_inferred(one: Any, shown: Any) -> None:
    """Compare what a page shows with what Python infers from the facts of its state."""
    rules = one.words.vocabulary.rules[shown["state"]["rules"]]
    facts = {key: value_of(one, key, fact) for key, fact in shown["state"]["facts"].items()}
    degrees = [0.0] * len(rules.base.rules)
    for key, answer in rules.base.infer(facts).items():
        found = shown["values"][key]
        if isinstance(answer, Inference):
            assert found["source"] == answer.source
            assert float(found["value"]) == pytest.approx(answer.value, rel=ALIKE, abs=1e-15)
            for firing in answer.fired:
                degrees[firing.rule] = firing.degree
        else:
            assert (found["source"], found["value"]) == ("none", "")
    assert shown["degrees"] == pytest.approx(degrees, rel=ALIKE, abs=1e-15)


def explained(text: str, name: str, use: str, folder: Path) -> dict[str, Any]:
    """Return what ``tissuec explain --json`` says of a tissue in a file of its own."""
    path = folder / "mine.tis"
    path.write_text(f'language 1\nuse "{use}"\n{text}\n', encoding="utf-8")
    command = ["explain", str(path), "--tissue", name, "--json"]
    run = CliRunner().invoke(group, command, standalone_mode=False)
    assert run.exception is None and '"diagnostics"' not in run.stdout, run.output
    return json.loads(run.stdout)["tissues"][name]


# --- numbers --------------------------------------------------------------------------------


@pytest.mark.parametrize("positions", [16, pytest.param(200, marks=pytest.mark.slow)])
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_sliders_words_and_numbers_lead_to_what_is_explained(page, path, positions, tmp_path):
    opened(page, path, tmp_path)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    one = of_file(path)
    rules = next(iter(one.words.vocabulary.rules))
    cases = list(settings(one, rules, positions, seed=1))
    for number, shown in enumerate(page.evaluate(BY_HAND, cases)):
        assert_inferred(one, shown)
        if number % (positions // 4) == 0:
            page.evaluate(BY_HAND, [cases[number]])
            page.get_by_role("button", name="Copy the tissue").click()
            copied = page.evaluate("navigator.clipboard.readText()")
            assert copied == shown["text"]
            told = explained(copied, "my tissue", f"fuzzy/{path.stem}", tmp_path)
            for name, quantity in told["quantities"].items():
                value = float(shown["values"][key_of(name)]["value"])
                assert value == pytest.approx(quantity["value"], rel=ALIKE)


@pytest.mark.parametrize(
    "seed", [3, 14, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (21, 45, 58))]
)
def test_random_vocabularies_are_explored_and_their_tissues_compile(page, seed, tmp_path):
    one = vocabulary(seed)
    path = tmp_path / "words.tis"
    path.write_text(one.text, encoding="utf-8")
    opened(page, path, tmp_path)
    for rules in one.words.vocabulary.rules:
        page.evaluate(
            """(key) => { const menu = document.querySelector("#rules"); menu.value = key;
            menu.dispatchEvent(new Event("change")); }""",
            rules,
        )
        for shown in page.evaluate(BY_HAND, list(settings(one, rules, 20, seed))):
            assert shown["state"]["rules"] == rules
            assert_inferred(one, shown)
            words, warnings = read_words(
                Request(Source("words.tis", f"{one.text}{shown['text']}\n"))
            )
            tissue = words.tissues["my tissue"]
            mine = [w for w in warnings if w.span and w.span.start >= len(one.text)]
            assert {w.code for w in mine} <= {"W205"}  # hedges that change nothing
            for name, given in tissue.given.items():
                value = float(shown["values"][name]["value"])
                assert value == pytest.approx(given.value, rel=ALIKE, abs=1e-15)
            none = {
                key: found["told"].partition(". ")[0]
                for key, found in shown["values"].items()
                if found["source"] == "none"
            }
            # The text by itself has no file in which rules have a place.
            reasons = {k: text.partition(" (the")[0] for k, text in tissue.missing.items()}
            assert (
                reasons.items() <= {k: v.partition(" (the")[0] for k, v in none.items()}.items()
            )
            others = {none[key] for key in none.keys() - tissue.missing.keys()}
            assert others <= {f"no rule of {rules} concludes it"}


def test_every_tissue_to_start_from_has_its_own_numbers(page, tmp_path):
    path = library() / "fuzzy" / "soft_tissue.tis"
    opened(page, path, tmp_path)
    presets = {one["name"]: one for one in document(Request.file(path))["presets"]}
    start = page.get_by_label("Start from")
    assert start.locator("option").all_text_contents()[1:] == list(presets)
    assert {"fallopian tube", "scarred tube", "tendon", "liver"} <= set(presets)
    shown = {}
    for name in presets:
        start.select_option(label=name)
        (shown[name],) = page.evaluate(BY_HAND, [[]])
        values = page.locator(".quantity .value").all_text_contents()
        shown[name]["told"] = dict(zip(shown[name]["values"], values, strict=True))
    files = dict.fromkeys(one["file"] for one in presets.values())
    uses = [f'use "{file}"' for file in files]
    text = "\n".join(["language 1", *uses, *(one["text"] for one in shown.values()), ""])
    tissues = read_words(Request(Source("", text)))[0].tissues
    for name, one in shown.items():
        theirs, ours = tissues[name].given, tissues[f"my {name}"].given
        assert {k: g.value for k, g in ours.items()} == {k: g.value for k, g in theirs.items()}
        for key, told in one["told"].items():
            assert told == shown_value(theirs[key])


# --- what is said ---------------------------------------------------------------------------

ODD = """language 1
hedge very = shift(50 %, outward)
property firmness from 1 kPa to 100 kPa on log scale { evenly = [soft, hard] }
property mass of it from 0 to 1 { evenly = [a] }
quantity spring constant from 2 N/m to 2000 N/m on log scale {
  evenly = [low, high]; applies to each spring
}
quantity crushing force from 1 N to 2 N { evenly = [low, high]; applies to each spring }
quantity viscosity from 1 N*s/m to 2 N*s/m {
  evenly = [low, high]; applies to each spring; otherwise is high
}
rules simple { if firmness is very hard and "mass of it" is a then spring constant is high }
param most = 3 N
tissue steel {
  described in simple
  firmness = 2 * 20 kPa
  "mass of it" is a
  spring law is toe { strain = 3 % }
  breaking force = most / 2
  crushing force is none
  viscosity = 2 N*s/m per 1 mm
}
""".replace("property mass of it", 'property "mass of it"')


@pytest.fixture
def odd(page, tmp_path):
    path = tmp_path / "odd.tis"
    path.write_text(ODD, encoding="utf-8")
    return opened(page, path, tmp_path)


def test_what_nothing_concludes_is_told_as_the_compiler_tells_it(odd):
    odd.get_by_role("button", name="soft").click()
    told = {
        box.get_attribute("data-key"): box.text_content()
        for box in odd.locator(".quantity").all()
    }
    assert "no rule of simple fires for these words" in told["spring constant"]
    assert "TIS206" in told["spring constant"]
    assert "no rule of simple concludes it. Without it: none." in told["crushing force"]
    assert "1.88 N*s/m" in told["viscosity"] and "fallback high" in told["viscosity"]
    odd.get_by_label("mass of it", exact=True).first.focus()
    odd.get_by_role("checkbox", name="mass of it").uncheck()
    assert "the tissue does not say: mass of it" in odd.locator(".told").first.text_content()
    assert "mass of it" not in odd.locator("#text").text_content()


def test_numbers_take_units_and_say_what_is_wrong(odd):
    field = odd.get_by_label("firmness as a number")
    error = odd.locator('.property[data-key="firmness"] .error')
    for wrong, told in {
        "50": "write a unit, such as 0.5 kPa",
        "50 mm": "firmness is a pressure (Pa); mm is not",
        "50 kQ": '"kQ" is not a unit',
        "200 kPa": "outside the range from 1 kPa to 100 kPa",
        "hard": "write a number, such as 0.5 kPa",
        "-3 kPa": "outside the range",
    }.items():
        field.fill(wrong)
        field.press("Tab")
        assert told in error.text_content(), wrong
        assert field.get_attribute("aria-invalid") == "true"
    field.fill("0.05 MPa")
    field.press("Tab")
    assert error.text_content() == ""
    assert "firmness = 0.05 MPa" in odd.locator("#text").text_content()


def test_what_a_tissue_writes_itself_stays_and_can_be_compiled(odd, tmp_path):
    odd.get_by_label("Start from").select_option(label="steel")
    text = odd.locator("#text").text_content()
    assert text.startswith("tissue my steel like steel {")
    assert "breaking force = 1.5 N" in text and "crushing force is none" in text
    assert "viscosity = 2 N*s/m per 1 mm" in text and "firmness = 40000.0 Pa" in text
    words, _ = read_words(Request(Source("", f"{ODD}{text}\n")))
    ours, theirs = words.tissues["my steel"], words.tissues["steel"]
    assert {k: g.value for k, g in ours.given.items()} == {
        k: g.value for k, g in theirs.given.items()
    }
    assert ours.laws == theirs.laws
    odd.get_by_role("checkbox", name="mass of it").uncheck()  # "like" would bring it back
    text = odd.locator("#text").text_content()
    assert text.startswith("tissue my steel {") and "without the spring law of steel" in text
    read_words(Request(Source("", f"{ODD}{text}\n")))


def test_any_name_compiles(odd):
    for name in ("wall of organ", 'Müller\'s "own" & <b>x</b>', "", "if", "3a"):
        odd.locator("#name").fill(name)
        text = odd.locator("#text").text_content()
        words, _ = read_words(Request(Source("", f"{ODD}{text}\n")))
        assert len(words.tissues) == 2, name


def test_a_state_is_kept_and_given_back(odd):
    odd.get_by_label("Start from").select_option(label="steel")
    odd.get_by_role("button", name="hard").click()
    odd.get_by_label("hedge of firmness").select_option(label="very")
    before = odd.evaluate(BY_HAND, [[]])
    odd.reload()
    assert odd.evaluate(BY_HAND, [[]]) != before
    odd.get_by_text("State", exact=True).click()
    odd.locator("#state").fill(json.dumps(before[0]["state"]))
    odd.get_by_role("button", name="Restore").click()
    assert odd.evaluate(BY_HAND, [[]]) == before
    for wrong in ("{", '{"rules": "no"}', '{"rules": "simple", "facts": {"firmness": "is x"}}'):
        odd.locator("#state").fill(wrong)
        odd.get_by_role("button", name="Restore").click()
        assert odd.locator("#wrong").text_content()
        odd.locator("#name").focus()
        assert odd.locator("#text").text_content() == before[0]["text"]


def test_it_is_worked_by_keys_alone(page, tmp_path):
    opened(page, library() / "fuzzy" / "soft_tissue.tis", tmp_path)
    slider = page.get_by_role("slider", name="hardness", exact=True)
    slider.focus()
    fact = page.locator('.property[data-key="hardness"] .fact')
    for key, told in (
        ("ArrowRight", "= 0.51"), ("Shift+ArrowLeft", "= 0.509"), ("End", "= 1"),
        ("PageDown", "is hard"), ("PageDown", "is medium"), ("Home", "= 0"),
    ):  # fmt: skip
        slider.press(key)
        assert fact.text_content() == told
    assert "soft 1" in slider.get_attribute("aria-valuetext")
    page.get_by_role("checkbox", name="hardness").press("Space")
    assert fact.text_content() == "not given"


def test_everything_that_can_be_worked_has_a_name(page, tmp_path):
    opened(page, library() / "fuzzy" / "soft_tissue.tis", tmp_path)
    nameless = page.evaluate("""() => [...document.querySelectorAll(
        "button, input, select, textarea, canvas, pre")]
      .filter((one) => one.offsetParent && !one.textContent.trim()
        && !one.getAttribute("aria-label") && !one.labels?.[0]?.textContent.trim())
      .map((one) => one.outerHTML)""")
    assert nameless == []


def test_text_is_readable_in_light_and_dark(page, tmp_path):
    opened(page, library() / "fuzzy" / "soft_tissue.tis", tmp_path)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        for selector in (".fact", ".told", "#sentences li", ".ticks button", "#copy", ".ends"):
            assert page.evaluate(CONTRAST, selector) >= 4.5, (scheme, selector)


#: The ratio of contrast (WCAG 2) of an element's letters with what is behind them.
CONTRAST = """(selector) => {
  const pixel = (colour) => {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 1;
    const context = canvas.getContext("2d");
    context.fillStyle = colour;
    context.fillRect(0, 0, 1, 1);
    return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const luminance = (colour) => {
    const [r, g, b] = pixel(colour).map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92
      : ((v / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const element = document.querySelector(selector);
  let behind = element;
  const isClear = (one) => getComputedStyle(one).backgroundColor === "rgba(0, 0, 0, 0)";
  while (isClear(behind)) behind = behind.parentElement;
  const both = [getComputedStyle(element).color, getComputedStyle(behind).backgroundColor];
  const [low, high] = both.map(luminance).sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
}"""


# --- the map --------------------------------------------------------------------------------


def test_the_map_shows_the_values_of_its_places(page, tmp_path):
    opened(page, library() / "fuzzy" / "soft_tissue.tis", tmp_path)
    canvas = page.locator('.map canvas[aria-label*=" over hardness and elasticity"]')
    canvas.wait_for()
    (shown,) = page.evaluate(BY_HAND, [[]])
    one = of_file(library() / "fuzzy" / "soft_tissue.tis")
    base = one.words.vocabulary.rules["soft tissue"].base
    facts = {key: value_of(one, key, fact) for key, fact in shown["state"]["facts"].items()}
    middles = [(k + 0.5) / 72 for k in range(72)]
    values = [
        base.infer(facts | {"hardness": x, "elasticity": y})["spring constant"].value
        for x in middles
        for y in middles
    ]
    ends = [show(value, STIFFNESS) for value in (min(values), max(values))]
    assert f"spring constant from {ends[0]} to {ends[1]}" in canvas.get_attribute("aria-label")
    size = canvas.bounding_box()["width"]
    canvas.click(position={"x": 0.9 * size, "y": 0.2 * size})
    (shown,) = page.evaluate(BY_HAND, [[]])
    facts = shown["state"]["facts"]
    assert float(facts["hardness"].split()[1]) == pytest.approx(0.9, abs=0.01)
    assert float(facts["elasticity"].split()[1]) == pytest.approx(0.8, abs=0.01)
