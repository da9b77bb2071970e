"""Values that no living tissue has: one warning each, and the unit that was meant."""

from tests.every import every
from tests.scene.test_idle_words import codes, diagnostics
from tissuec.core.resources import library
from tissuec.pipeline import read_words
from tissuec.scene.request import Request
from tissuec.scene.usual_ranges import USUAL

SCENE = """language 1
tissue gel {{ Young's modulus = {modulus}; density = {density}; retardation time = 5 ms }}
body organ {{
  mesh is lattice {{
    cell = {cell}
    box from (0, 0, 0) mm to {box}
  }}
  tissue is gel
}}
set foot = nodes of organ where z == 0 mm
tool finger {{ kind is probe; centre = {centre}; radius = 5 mm }}
environment {{ gravity = {gravity}; contact is tools only; friction = 0 }}
script {{ at 0 s: fix foot }}
simulate {{ duration = 0.1 s; tolerance = 1e-3 }}
"""
USUALLY = {
    "modulus": "5 kPa", "density": "1.06 g/cm^3", "cell": "10 mm", "box": "(20, 20, 10) mm",
    "centre": "(10, 10, 25) mm", "gravity": "(0, 0, -9.81) m/s^2",
}  # fmt: skip


def scene(**odd):
    return SCENE.format(**(USUALLY | odd))


def test_usual_values_are_not_warned_of():
    assert codes(scene()) == []


@every(
    ("odd", "said", "meant"),
    [
        ({"density": "1.06 kg/m^3"}, "density of gel is 1.06 kg/m^3", ["1.06 g/cm^3"]),
        ({"density": "1060 g/cm^3"}, "density of gel is", ["1060 kg/m^3"]),
        ({"modulus": "5.5 GPa"}, "Young's modulus of gel is 5.5 GPa", ["5.5 kPa", "5.5 MPa"]),
        ({"modulus": "5 Pa"}, "Young's modulus of gel is 5 Pa", ["5 kPa", "5 MPa"]),
        ({"centre": "(20, 10, 30) m"}, "distance of finger from all bodies is 37.39 m", []),
        ({"cell": "40 um", "box": "(160, 80, 80) um", "centre": "(0, 0, 0) mm"},
         "organ is only 160 um", []),
        ({"cell": "10 m", "box": "(20, 20, 10) m", "centre": "(10, 10, 25) m"},
         "organ is as large as 20 m", []),
        ({"gravity": "(0, 0, -9810) m/s^2"}, "gravity is 9810 m/s^2", []),
    ],
)  # fmt: skip
def test_a_slip_of_a_unit_is_warned_of_once_and_its_edits_cure_it(odd, said, meant):
    text = scene(**odd)
    found = [one for one in diagnostics(text) if one.code == "W504"]
    assert len(found) == 1, found
    assert said in found[0].message and "usual range" in found[0].message
    assert [edit.text for edit in getattr(found[0].hint, "edits", ())] == meant
    for edit in found[0].hint.edits:
        mended = text[: edit.span.start] + edit.text + text[edit.span.end :]
        assert "W504" not in codes(mended)


def test_what_follows_from_several_numbers_is_guessed_in_words():
    (found,) = diagnostics(scene(gravity="(0, 0, -9810) m/s^2"))
    assert "9810 mm/s^2" in found.hint


def test_a_scene_of_any_scale_is_only_warned_of():
    text = scene(cell="40 km", box="(160, 80, 80) km", centre="(0, 0, 200) km")
    assert codes(text) == ["W504"]


def test_a_number_from_the_command_line_is_checked_like_one_in_a_text():
    (found,) = diagnostics(scene(), "density of gel = 1.06 kg/m^3")
    assert found.code == "W504" and found.span.source.name == "--set"
    vary = "vary density of gel = [1.06 kg/m^3, 1 g/cm^3]"
    block = f"study s {{ {vary}; measure a = max(speed of organ) }}\n"
    assert codes(scene() + block) == ["W504"]


def test_typical_values_are_usual_and_all_presets_are():
    for usual in USUAL.values():
        assert usual.low <= usual.typical[0] < usual.typical[1] <= usual.high
    for path in (library() / "matter").glob("*.tis"):
        for tissue in read_words(Request.file(path))[0].tissues.values():
            for key, given in tissue.given.items():
                assert key not in USUAL or USUAL[key].holds(given.value)
