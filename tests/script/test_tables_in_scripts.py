"""Tables of motions and forces beside a scene: separators, units, and what is refused."""

import pytest

from tissuec.core.errors import CompileError
from tissuec.pipeline import check_request
from tissuec.scene.request import Request
from tissuec.script.forms import texts_of

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


@pytest.mark.parametrize("form", [form for form in texts_of("move") if "path.csv" in form])
def test_the_forms_of_paths_can_be_written(action, form):
    moved = action(form.replace("SET", "b"))
    displacement = sum(
        vector * profile.at(0.05)[0]
        for vector, profile in zip(moved.vectors, moved.profiles, strict=True)
    )
    assert displacement == pytest.approx([0, 1e-3, 0])


RISE = ([0, 1.5, 2.5], [0, 1, 0.5])
RISES = {
    "decimal commas": "time;factor\n0;0\n1,5;1\n2,5;0,5\n",
    "decimal commas and tabs": "time\tfactor\n0\t0\n1,5\t1\n2,5\t0,5\n",
    "decimal commas without a header": "0;0\n1,5;1\n2,5;0,5\n",
    "blanks": "time factor\n0 0\n1.5 1\n2.5 0.5\n",
    "quotes and remarks": '# rise\n"time","the factor, relative"\n0,0\n# top\n1.5,1\n2.5,0.5\n',
    "milliseconds": "t_ms,factor\n0,0\n1500,1\n2500,0.5\n",
    "milliseconds in brackets": "time [ms];factor (relative)\n0;0\n1500;1\n2500;0,5\n",
    "minutes above": "# t/min factor\n0 0\n0.025 1\n0.041666666666666664 0.5\n",
}


@pytest.mark.parametrize("table", RISES)
def test_factors_are_read_as_they_are_written(action, table):
    moved = action('move b by (1, 0, 0) mm using table "path.csv"', RISES[table])
    (profile,) = moved.profiles
    assert profile.times == pytest.approx(RISE[0])
    assert profile.values.tolist() == RISE[1]


def test_displacements_with_decimal_commas_are_read(action):
    table = "t_ms;x_mm;y_mm;z_mm\n0;0;0;0\n500;0,5;1,5;-2,5\n"
    moved = action('move b along table "path.csv" in mm', table)
    assert [profile.times.tolist() for profile in moved.profiles] == [[0, 0.5]] * 3
    ends = [profile.values[-1] for profile in moved.profiles]
    assert ends == pytest.approx([0.5e-3, 1.5e-3, -2.5e-3])


def test_columns_may_be_named_by_symbols_that_are_units_too(action):
    action('push b with (1, 0, 0) N using table "path.csv"', "t,g\n0,0\n1,2\n")


def test_a_long_header_is_shown_in_part(action):
    header = ",".join(f"column {n}" for n in range(99))
    zeros = ",".join("0" * 99)
    with pytest.raises(CompileError) as failure:
        action('push b with (1, 0, 0) N using table "path.csv"', f"{header}\n{zeros}\n")
    (found,) = failure.value.diagnostics
    assert "99 columns (column 0, column 1," in found.message
    assert len(found.message) < 120
