"""Tables of motions and forces beside a scene: separators, units, and what is refused."""

import pytest

from tissuec.pipeline import check_request
from tissuec.scene.request import Request
from tissuec.script.verbs.move import Move

SCENE = """language 1
tissue cord {{ spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g }}
body pair {{ mesh is explicit; tissue is cord }}
table nodes of pair in mm with columns "id x" {{ 1 0; 2 10 }}
table springs of pair with columns "a b" {{ 1 2 }}
set b = nodes of pair in [2]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ from 0 s to 3 s: {order} }}
simulate {{ duration = 3 s }}
"""
PATH = "t,x,y,z\n0,0,0,0\n0.05,0,1,0\n0.1,0,2,0\n"


@pytest.fixture
def action(tmp_path):
    """Return the action of an order beside a table called path.csv."""

    def compiled(order: str, table: str = PATH):
        (tmp_path / "path.csv").write_text(table, encoding="utf-8")
        scene = tmp_path / "scene.tis"
        scene.write_text(SCENE.format(order=order), encoding="utf-8")
        found, _ = check_request(Request.file(scene))
        assert found is not None
        (event,) = found.plan.events
        return event.action

    return compiled


@pytest.mark.parametrize("form", [form for form in Move.forms if "path.csv" in form])
def test_the_forms_of_paths_can_be_written(action, form):
    moved = action(form.replace("SET", "b"))
    displacement = sum(
        vector * profile.at(0.05)[0]
        for vector, profile in zip(moved.vectors, moved.profiles, strict=True)
    )
    assert displacement == pytest.approx([0, 1e-3, 0])
