"""A force on triangles in two files of a plug-in is known everywhere: docs/extending.md."""

import importlib.util
import shutil
import sys
from math import pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import tissuec
from tests.test_docs import DOCS, blocks
from tests.validate.scenes import compiled_scene, silent
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.errors import TissueError
from tissuec.forces.acting import FORCES
from tissuec.learn.fit.learning import learn
from tissuec.lsp.vocabulary import frame_fields
from tissuec.mechanics.settling import settle
from tissuec.pipeline import compile_request
from tissuec.results.blocks.file import write_blocks
from tissuec.results.export import frame_shape
from tissuec.results.fields import FIELDS
from tissuec.scene.reading.parts import forget
from tissuec.scene.request import Request
from tissuec.script.measures.snapshot import Snapshot
from tissuec.validate.forces import FORMULAS
from tissuec.validate.validation import validate
from tissuec.view.player.options import Options
from tissuec.view.player.page import render_film
from tissuec.view.player.reading import read_film

MEMBER, OUTPUT = "area elasticity", "membrane tension"
FILES = {
    block.name: block.text
    for block in blocks(DOCS / "extending.md")
    if block.name.endswith("area_elasticity.py")
}
#: An icosahedron, which keeps its shape: radius, edge, area, volume.
RADIUS = 10e-3
EDGE = RADIUS / sin(2.0 * pi / 5.0)
AREA, VOLUME = 5.0 * sqrt(3.0) * EDGE**2, 5.0 * (3.0 + sqrt(5.0)) / 12.0 * EDGE**3
MODULUS, SPRING, BULK, MASS = 2.0, 0.1, 5e3, 50e-6
DROP = """language 1
tissue film {{ spring constant = 0.1 N/m; viscosity = 2 mN*s/m; mass = 50 mg }}
body drop {{
  mesh is sphere {{ centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 0 }}; tissue is film
}}
force skin {{ kind is area elasticity; acts on drop; modulus = {modulus} N/m }}
environment {{ gravity = (0, 0, 0) m/s^2; damping = 10 mN*s/m }}
script {{ at 0 s: preserve volume of drop with 5 kPa; {script} }}
simulate {{ duration = 20 ms; tolerance = 1e-6 }}
output {{ trajectory with [membrane tension, pressure] every 5 ms }}
{more}
"""
INFLATED = "from 0 s to 10 ms: inflate drop to 3.8 ml using smooth profile"
LEARN = 'learn skin { data = "truth.vtkhdf"; fit = positions(drop); adjust = modulus }'
#: A sheet that is drawn apart, and cut while it is.
SHEET = """language 1
tissue film {{ spring constant = 1 N/m; viscosity = 5 mN*s/m; mass = 10 mg }}
body sheet {{ tissue is film; mesh is sheet {{ corner = (0, 0, 0) mm
  first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm; columns = 5; rows = 3 }} }}
set left = nodes of sheet where x < 1 mm
set right = nodes of sheet where x > 19 mm
force skin {{ kind is area elasticity; acts on {on}; modulus = 4 N/m }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix left
  from 0 s to 10 ms: move right by (4, 1, 3) mm using smooth profile
  at 12 ms: cut sheet along plane through (8, 0, 0) mm facing (1, 0, 0)
}}
simulate {{ duration = 20 ms }}
output {{ trajectory with {asked} every 4 ms }}
"""


def drop(script="", *, modulus=MODULUS, more=""):
    return DROP.format(script=script, modulus=modulus, more=more)


def sheet(on="sheet", asked=OUTPUT):
    return SHEET.format(on=on, asked=asked)


def forget_words():
    """Forget the words of members, also those that editors offer."""
    forget()
    for name in [each for each in sys.modules if each.startswith("tissuec.lsp.")]:
        for known in vars(sys.modules[name]).values():
            getattr(known, "cache_clear", lambda: None)()


@pytest.fixture(scope="module", autouse=True)
def plugged(tmp_path_factory):
    """Add the two files of the page as modules of another package."""
    folder = tmp_path_factory.mktemp("membranes")
    forget_words()
    before = len(FORCES), len(FORMULAS)
    for number, text in enumerate(FILES.values()):
        path = folder / f"membranes_{number}.py"
        path.write_text(text, encoding="utf-8")
        spec = importlib.util.spec_from_file_location(path.stem, path)
        sys.modules[path.stem] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    assert (len(FORCES), len(FORMULAS)) == tuple(count + 1 for count in before)
    yield
    for family in (FORCES, FORMULAS):
        del family._members[MEMBER]
    forget_words()
    for number in range(len(FILES)):
        del sys.modules[f"membranes_{number}"]


@pytest.fixture(scope="module")
def blown(plugged, tmp_path_factory):
    """Return a run of a drop that is inflated."""
    path = tmp_path_factory.mktemp("drop") / "drop.vtkhdf"
    return tissuec.run(drop(INFLATED), out=path, companion="off")


def test_there_are_two_files():
    assert list(FILES) == [
        "tissuec/forces/acting/area_elasticity.py",
        "tissuec/validate/forces/area_elasticity.py",
    ]


def test_an_inflated_drop_rests_at_the_pressure_of_laplace():
    """2 T / r, with the radius r of the ball that touches all faces, and what springs add."""
    state = state_at_start(compiled_scene(drop("at 0 s: inflate drop to 3.8 ml")))
    settle(state, np.ones(state.network.node_count, dtype=bool))
    due = 3.8e-6 / VOLUME

    def unbalanced(size):
        membrane = 2.0 * MODULUS * AREA * (size**2 - 1.0) * size
        springs = 30.0 * SPRING * EDGE**2 * (size - 1.0)
        return membrane + springs - 3.0 * BULK * VOLUME * (due - size**3) * size**2

    size = brentq(unbalanced, 1.0, 1.5, xtol=1e-15)
    assert np.linalg.norm(state.position, axis=1) == pytest.approx(size * RADIUS, rel=1e-9)
    found = Snapshot.of(state)
    tension, pressure = (FIELDS[name].sample(found) for name in (OUTPUT, "pressure"))
    assert tension == pytest.approx(MODULUS * (size**2 - 1.0), rel=1e-8)
    touching = 3.0 * size * VOLUME / AREA
    springs = 10.0 * SPRING * EDGE**2 * (size - 1.0) / (VOLUME * size**2)
    assert pressure == pytest.approx(2.0 * tension[0] / touching + springs, rel=1e-8)


def test_a_drop_breathes_as_one_mass():
    """The highest mode is the only one that changes the volume."""
    stiffness = 4.0 * MODULUS * AREA + 30.0 * SPRING * EDGE**2 + 9.0 * BULK * VOLUME
    omega = sqrt(stiffness / (12.0 * MASS * RADIUS**2))
    found = max(mode.frequency for mode in tissuec.modes(drop(), count=36))
    assert found == pytest.approx(omega / (2.0 * pi), rel=1e-9)


@pytest.mark.parametrize("integrator", ["dop853", "esdirk43"])
def test_the_second_file_agrees_on_a_sheet_that_is_cut(integrator):
    text = sheet().replace("20 ms }", f"20 ms; integrator is {integrator} }}")
    found = validate(compiled_scene(text), method="DOP853", rtol=None, progress=silent)
    assert found.verdict == "kept", found.reasons


def test_triangles_act_until_they_are_torn():
    """Frames show no torn triangles, and none of them acts."""
    compiled = compiled_scene(sheet())
    with tissuec.run(sheet(), companion="off") as run:
        x = run.position[:, np.array(run.network.skin)]
        sides = x[:, :, 1:] - x[:, :, :1]
        area = 0.5 * np.linalg.norm(np.cross(sides[:, :, 0], sides[:, :, 1]), axis=-1)
        torn = (x[0, :, :, 0].min(axis=1) < 8e-3) & (x[0, :, :, 0].max(axis=1) > 8e-3)
        cut = run.times > 0.0119
        expected = 4.0 * (area / area[0] - 1.0)
        expected[np.ix_(cut, torn)] = np.nan
        found = np.array(run.fields[OUTPUT])
        assert found == pytest.approx(expected, abs=1e-9, nan_ok=True)
        assert cut.any() and torn.any() and np.nanmax(found) > 0.1
    state = state_at_start(compiled)
    left = state.position[state.springs.ends, 0] < 8e-3
    state.alive = left[:, 0] == left[:, 1]
    state.position = 1.1 * state.position
    (tension,) = (FIELDS[name].sample(Snapshot.of(state)) for name in (OUTPUT,))
    assert np.array_equal(tension == 0.0, torn)


def test_its_number_is_learnt_from_a_run_by_exact_derivatives(blown, tmp_path):
    path = tmp_path / "drop.tis"
    shutil.copy(blown.path, tmp_path / "truth.vtkhdf")
    path.write_text(drop(INFLATED, modulus=1.5, more=LEARN))
    request = Request.file(path)
    compiled, _ = compile_request(request)
    learnt = learn(compiled, compiled.fit_problems[0], request)
    assert "exact derivatives of every step" in learnt.method
    assert float(learnt.estimates[0].value[0]) == pytest.approx(MODULUS, rel=1e-5)


def test_frames_exports_and_pages_have_its_output(blown, tmp_path):
    field = blown.fields[OUTPUT]
    tension, size = np.array(field), np.linalg.norm(blown.position, axis=-1) / RADIUS
    assert field.unit == "N/m"
    assert tension == pytest.approx(
        MODULUS * (size[:, :1] ** 2 - 1.0) + 0.0 * tension, abs=1e-6
    )
    assert tension[-1].min() > 0.1
    shape = frame_shape(blown, 4)
    assert shape.cell_data["membrane_tension"][-20:] == pytest.approx(tension[4])
    write_blocks(blown, None, tmp_path / "drop.blocks.vtkhdf", links=False)
    assert b"membrane_tension" in (tmp_path / "drop.blocks.vtkhdf").read_bytes()
    page = render_film(read_film(blown, Options()), blown, Options())
    assert "tension of each triangle of a membrane" in page
    assert OUTPUT in frame_fields()


@pytest.mark.parametrize(
    ("scene", "message", "hint"),
    [
        (
            sheet("left"),
            "force skin: it acts on the triangles of surfaces, but these nodes are the corners",
            "",
        ),
        (
            sheet().replace("kind is area elasticity; acts on sheet; modulus = 4 N/m",
                            "kind is foundation; acts on sheet; stiffness = 1 kPa/m"),
            "the membrane tension is that of forces of the kind area elasticity",
            "force NAME { kind is area elasticity; acts on BODY",
        ),
        (sheet(asked="membrane tenson"), "is not a field of frames", '"membrane tension"'),
        (sheet().replace("modulus", "modulas"), "modulas", '"modulus"'),
    ],
)  # fmt: skip
def test_mistakes_about_it_are_told(scene, message, hint):
    with pytest.raises(TissueError) as caught:
        tissuec.compile(scene)
    assert message in str(caught.value)
    assert hint in str(caught.value)
