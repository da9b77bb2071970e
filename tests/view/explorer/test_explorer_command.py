"""``tissuec words --explore``: where the page goes, what is in it, and what is refused."""

import json
import re
from pathlib import Path

import pytest
from click import UsageError
from click.testing import CliRunner

from tissuec.cli import group
from tissuec.core.errors import TissueError
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.lang.words import written_name
from tissuec.pipeline import read_words
from tissuec.scene.request import Request
from tissuec.view.explorer.page import document, render
from tissuec.view.explorer.tables import tables

WORDS = """language 1
property firmness from 0 to 1 { evenly = [soft, hard] }
quantity mass from 1 mg to 1 g { evenly = [light, heavy]; applies to each node }
rules mine { if firmness is hard then mass is heavy }
"""
TISSUE = 'language 1\nuse "{}"\ntissue {} {{ described in mine; firmness is hard }}\n'


def words(*arguments: str) -> str:
    command = ["words", *map(str, arguments)]
    return (
        CliRunner().invoke(group, command, standalone_mode=False, catch_exceptions=False).output
    )


def said(text: str) -> dict:
    """Return what a page holds."""
    return json.loads(re.search(r'id="data"[^>]*>(.*)</script>', text)[1])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.tis").write_text(WORDS, encoding="utf-8")
    return tmp_path


def test_the_page_is_named_after_the_vocabulary(folder):
    assert words("mine", "--explore") == (
        "mine.html: 1 properties, 1 quantities, 1 rules, 0 tissues\n"
    )
    assert said(Path("mine.html").read_text(encoding="utf-8"))["title"] == "mine"


def test_json_says_where_it_is(folder):
    told = json.loads(words("mine", "--explore", "-o", "page.html", "--json"))
    assert told["file"] == "page.html" and told["bytes"] == Path("page.html").stat().st_size


def test_open_shows_it_in_a_browser(folder, monkeypatch):
    shown = []
    monkeypatch.setattr("webbrowser.open", shown.append)
    words("mine", "--explore", "--open")
    assert shown == [(folder / "mine.html").as_uri()]


@pytest.mark.parametrize("option", [("-o", "page.html"), ("--open",)])
def test_options_of_the_page_need_the_page(folder, option):
    with pytest.raises(UsageError, match="need --explore"):
        words("mine", *option)


def test_it_is_not_written_over_the_vocabulary(folder):
    with pytest.raises(UsageError, match=r"must end in \.html"):
        words("mine", "--explore", "-o", "mine.tis")
    (folder / "link.html").symlink_to(folder / "mine.tis")
    with pytest.raises(TissueError, match="is the input file"):
        words("mine", "--explore", "-o", "link.html")


def test_words_without_rules_have_nothing_to_explore(folder):
    Path("bare.tis").write_text(WORDS.partition("rules")[0], encoding="utf-8")
    with pytest.raises(TissueError, match="has no rules"):
        words("bare", "--explore")


def test_tissues_come_from_the_libraries_that_use_these_very_rules(folder):
    Path("shelf/tissues").mkdir(parents=True)
    Path("library/parts").mkdir(parents=True)
    for place in ("shelf", "library"):
        Path(place, "mine.tis").write_text(WORDS, encoding="utf-8")
        Path(place, "other.tis").write_text(WORDS.replace("hard then", "soft then"))
    Path("library/parts/two.tis").write_text(TISSUE.format("mine", "two"))
    Path("library/parts/three.tis").write_text(TISSUE.format("other", "three"))
    Path("library/parts/broken.tis").write_text(TISSUE.format("mine", "}"))
    Path("library/parts/scene.tis").write_text(
        TISSUE.format("mine", "four") + "simulate { duration = 1 s }\n"
    )
    Path("shelf/tissues/one.tis").write_text(TISSUE.format("mine", "one"))
    words("mine", "--explore", "--library", "shelf")
    page = said(Path("mine.html").read_text(encoding="utf-8"))
    assert {(one["name"], one["file"]) for one in page["presets"]} == {
        ("one", "tissues/one"),
        ("two", "parts/two"),
    }


def test_a_page_needs_nothing_else():
    text = render(document(Request.file(library() / "fuzzy" / "soft_tissue.tis")))
    outside = set(re.findall(r"https?://[^\s\"')]+", text))
    assert outside == {"http://www.w3.org/2000/svg"}  # a name, which nobody fetches
    assert "default-src 'none'" in text
    assert len(text) < 150_000
    assert str(library()) not in text  # a page is sent to others


def test_texts_cannot_end_the_script():
    text = WORDS.replace("language 1", 'language 1\nabout "</script><b>{{code}}</b>"', 1)
    page = render(document(Request(Source("mine.tis", text, Path("mine.tis")))))
    assert page.count("</script>") == 2 and "&lt;/script&gt;" in page
    assert said(page)["about"] == "</script><b>{{code}}</b>"


def test_a_file_says_how_it_is_used():
    shipped = document(Request.file(library() / "fuzzy" / "soft_tissue.tis"))
    assert shipped["use"] == "fuzzy/soft_tissue"
    own = document(Request(Source("mine.tis", WORDS, Path("folder/mine.tis"))))
    assert own["use"] == "./mine"
    scene = f"{WORDS}simulate {{ duration = 1 s }}\n"
    assert document(Request(Source("mine.tis", scene, Path("mine.tis"))))["use"] == ""


def test_a_phrase_that_is_a_word_is_no_hedged_word():
    text = WORDS.replace("[soft, hard]", "[very soft, soft, hard]").replace(
        "property", "hedge very = shift(50 %, outward)\nproperty", 1
    )
    firmness = tables(read_words(Request(Source("", text)))[0])["properties"][0]
    hedged = {word["word"]: list(word["hedged"]) for word in firmness["words"]}
    assert hedged == {"very soft": ["very"], "soft": [], "hard": ["very"]}


def test_rules_are_told_as_written_without_remarks():
    rule = (
        "if (firmness is  not soft)  # so; they say\n  and firmness is Hard then mass is heavy"
    )
    text = WORDS.replace("if firmness is hard then mass is heavy", rule)
    (rules,) = tables(read_words(Request(Source("", text)))[0])["rules"]
    assert "".join(part for _, part in rules["rules"][0]["parts"]) == (
        "if (firmness is not soft) and firmness is Hard then mass is heavy"
    )
    assert [kind for kind, _ in rules["rules"][0]["parts"] if kind] == ["not", "is", "then"]


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("hard", "hard"),
        ("very hard", "very hard"),
        ("head of pancreas", '"head of pancreas"'),
        ("3 layers", '"3 layers"'),
        ("Grösse_2", "Grösse_2"),
    ],
)
def test_names_stand_in_quotes_where_they_must(name, written):
    assert written_name(name) == written


def test_values_and_scales_have_the_units_of_explain():
    page = tables(read_words(Request(Source("", 'language 1\nuse "fuzzy/soft_matter"\n')))[0])
    rows = {row["key"]: (row["shown_units"][0][1], row["ends"]) for row in page["quantities"]}
    assert rows["cutting resistance"][0] == rows["toughness"][0] == "J/m^2"
    assert rows["strength"][1] == ["250 Pa", "4 GPa"]
    assert rows["young's modulus"][1] == ["70 Pa", "1.75 GPa"]
