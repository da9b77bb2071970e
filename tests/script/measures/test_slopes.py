"""The slope of one measure over another in a study: against a spring constant and NumPy."""

import numpy as np
import pytest

import tissuec
from tissuec.core.errors import CompileError

SCENE = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 1 g }
body rope { mesh is explicit; tissue is cord }
table nodes of rope in mm with columns "id x" { 1 0; 2 100; 3 200 }
table springs of rope with columns "a b" { 1 2; 2 3 }
set start = nodes of rope in [1]
set middle = nodes of rope in [2]
set end = nodes of rope in [3]
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix start
  from 0 s to 1 s: move end by (20, 0, 0) mm using smooth profile
}
simulate { duration = 1 s; integrator is equilibrium; step = 0.1 s }
output { force(end) every 0.1 s; position(end) every 0.1 s }
study stiffness {
  vary spring constant of cord = [20 N/m, 40 N/m]
  measure whole = slope(FORCE, PLACE)
  measure part = slope(FORCE, PLACE) from 0.2 s to 0.4 s
  measure squared = slope(PLACE * PLACE, PLACE)
  measure none = slope(force(end), position(start along (1, 0, 0)))
  MORE
}
""".replace("FORCE", "force(end along (1, 0, 0))").replace(
    "PLACE", "position(end along (1, 0, 0))"
)


def test_a_slope_is_that_of_the_line_of_least_squares(tmp_path):
    path = tmp_path / "rope.tis"
    path.write_text(SCENE.replace("MORE", ""))
    table = tissuec.study(path, out=tmp_path / "table.csv")
    # Two springs in a row are half as stiff as each.
    for name in ("whole", "part"):
        assert table.column(name).unit == "N/m"
        assert table.column(name).numbers == pytest.approx([10.0, 20.0], rel=1e-6)
    with tissuec.run(path, out=tmp_path / "rope.vtkhdf", companion="off") as result:
        place = result.logs["position of end"].value[:, 0]
    expected = np.polyfit(place, place**2, 1)[0]
    assert table.column("squared").numbers == pytest.approx(expected, rel=1e-9)
    assert np.isnan(table.column("none").numbers).all()  # over what does not change


@pytest.mark.parametrize(
    ("measure", "said"),
    [
        ("slope(force(end))", "the form is slope(MEASURE, MEASURE)"),
        ("max(force(end), force(start))", "the form is max(MEASURE)"),
    ],
)
def test_other_numbers_of_measures_are_refused(measure, said, tmp_path):
    path = tmp_path / "rope.tis"
    path.write_text(SCENE.replace("MORE", f"measure wrong = {measure}"))
    with pytest.raises(CompileError) as caught:
        tissuec.study(path, out=tmp_path / "table.csv")
    assert said in str(caught.value)
