"""The page of a run in a browser: no complaints, links that unfold, narrow screens, paper."""

import pytest

from tests.view.report.runs import ROD, page_of, run


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    folder = tmp_path_factory.mktemp("browser")
    path = folder / "rod.html"
    path.write_text(page_of(run(folder, ROD)), encoding="utf-8")
    return path.as_uri()


def test_the_page_opens_from_a_file_without_complaints(page, address):
    page.goto(address)
    assert page.title() == f"{page.locator('h1').inner_text()}: expectations fail"
    heads = page.locator("h2").all_inner_texts()
    assert heads[0] == "Motion" and heads[-1] == "Manifest"
    assert page.locator("section#motion iframe, section#motion p").count() >= 1


def test_a_link_into_a_folded_text_unfolds_it(page, address):
    page.goto(address)
    line = page.locator("#text-1-12")
    assert not line.is_visible()
    page.locator("#numbers a", has_text="words.tis:12").first.click()
    assert line.is_visible()
    box = line.bounding_box()
    assert box is not None and 0 <= box["y"] <= 800


def test_nothing_reaches_beyond_the_sides(page, address):
    for width in (360, 800, 1440):
        page.set_viewport_size({"width": width, "height": 800})
        if width == 360:
            page.goto(address)
        assert page.evaluate("document.documentElement.scrollWidth") <= width


READ = ("h1", "p.made", "nav a", "td a", ".mark", "pre.text", "pre.text .digits")


def test_words_are_dark_on_light_or_light_on_dark(page, address):
    """4.5 to 1 is what WCAG 2 (AA) asks of text."""
    page.goto(address)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        for selector in READ:
            assert contrast(page, selector) >= 4.5, (scheme, selector)


def test_paper_is_light_and_has_no_player(page, address):
    page.emulate_media(media="print", color_scheme="dark")
    page.goto(address)
    assert page.evaluate("getComputedStyle(document.documentElement).backgroundColor") == (
        "rgb(255, 255, 255)"
    )
    assert page.locator("nav").is_hidden()


CONTRAST = """selector => {
  // Any colour that CSS can compute, as a canvas paints it.
  const paint = colours => {
    const context = Object.assign(document.createElement("canvas"), {width: 1, height: 1})
      .getContext("2d");
    for (const colour of colours) { context.fillStyle = colour; context.fillRect(0, 0, 1, 1); }
    return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const light = colours => paint(colours).map(x => x / 255)
    .map(x => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4)
    .reduce((sum, x, i) => sum + x * [0.2126, 0.7152, 0.0722][i], 0);
  const element = document.querySelector(selector);
  const behind = [];
  for (let e = element; e; e = e.parentElement) {
    behind.unshift(getComputedStyle(e).backgroundColor);
  }
  const [a, b] = [light([...behind, getComputedStyle(element).color]), light(behind)];
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}"""


def contrast(page, selector):
    """Return the contrast of an element's letters against what is behind them."""
    return page.evaluate(CONTRAST, selector)
