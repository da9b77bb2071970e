"""Rules and words alternate: a wrong rule is found, and words do not bend for it."""

import numpy as np
import pytest

import tissuec
from tissuec.learn.fit.learning import learn
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

WORDS = """language 1
property firmness from 0 to 10 { evenly = [soft, medium, hard] }
quantity spring constant from 2 N/m to 200 N/m on log scale {
  evenly = [low, average, high]; applies to each spring
}
rules gel {
  if firmness is soft then spring constant is low
  if firmness is medium then spring constant is average
  if firmness is hard then spring constant is HARD
}
"""
SAMPLE = """tissue gel {k} {{ described in gel; firmness is {k}; viscosity = 60 mN*s/m
  mass = 0.5 g }}
body {k} gel {{ mesh is explicit; tissue is gel {k} }}
table nodes of {k} gel in mm with columns "id x y" {{ 1 0 {y}; 2 10 {y} }}
table springs of {k} gel with columns "a b" {{ 1 2 }}
set wall {k} = nodes of {k} gel in [1]
set end {k} = nodes of {k} gel in [2]
"""
KINDS = ("soft", "medium", "hard")
SCENE = (
    'language 1\nuse "./words"\nparam pull = 5 mN\n'
    + "".join(SAMPLE.format(k=k, y=10 * n) for n, k in enumerate(KINDS))
    + "environment { gravity = (0, 0, 0) m/s^2 }\nscript {\n"
    + "".join(
        f"  at 0 s: fix wall {k}\n  from 0 s to 0.1 s: push end {k} with pull along (1, 0, 0)\n"
        for k in KINDS
    )
    + "}\nsimulate { duration = 0.1 s; tolerance = 1e-6 }\n"
)
LESSON = """learn gels {
  data "data.csv" { pull = 6 mN }
  hold out "judge.csv"
  data "judge.csv" { pull = 9 mN }
  FITS
  revise rules of gel
  ADJUST
}
"""


@pytest.mark.parametrize("entry", ["adjust words of spring constant", ""])
def test_a_wrong_rule_is_found_and_words_stay(entry, tmp_path):
    (tmp_path / "words.tis").write_text(WORDS.replace("HARD", "high"))
    logs = "; ".join(f"position of end {k} every 5 ms" for k in KINDS)
    (tmp_path / "true.tis").write_text(f"{SCENE}output {{ {logs} }}\n")
    true, _ = compile_request(Request.file(tmp_path / "true.tis"))
    noise = np.random.default_rng(0)
    for name, pull in (("data", "6 mN"), ("judge", "9 mN")):
        run = tissuec.run(tmp_path / "true.tis", pull=pull)
        columns = [log.value[:, 0] for log in run.logs.values()]
        rows = np.column_stack(columns) + 5e-6 * noise.standard_normal((21, 3))
        times = next(iter(run.logs.values())).time
        lines = [",".join(["t_s", *KINDS])]
        lines += [",".join(map(str, (t, *row))) for t, row in zip(times, rows, strict=True)]
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    fits = "\n  ".join(
        f'fit = position(end {k} along (1, 0, 0)) using column "{k}" in m' for k in KINDS
    )
    fit_problem = LESSON.replace("FITS", fits).replace("ADJUST", entry)
    (tmp_path / "words.tis").write_text(WORDS.replace("HARD", "average"))
    (tmp_path / "scene.tis").write_text(SCENE + fit_problem)
    request = Request.file(tmp_path / "scene.tis")
    compiled, _ = compile_request(request)
    learnt = learn(compiled, compiled.fit_problems[0], request)
    (text,) = learnt.words.values()
    assert "if firmness is hard then spring constant is high" in text
    assert sum("concludes" in note for note in learnt.notes) == 1, learnt.notes
    # Judged by what neither chose nor was fitted, with the rules that are written.
    (judge,) = [one for one in learnt.fitted if one.held_out]
    assert judge.error < 0.2  # of which noise makes 0.1
    (tmp_path / "words.tis").write_text(text)
    again, _ = compile_request(request)
    for k in KINDS:
        mine, right = (
            scene.scene.tissues[f"gel {k}"].given["spring constant"].value
            for scene in (again, true)
        )
        assert mine == pytest.approx(right, rel=0.1)
