"""Tables of several designs whose measures are known functions, without any run."""

from itertools import product

import numpy as np

from tissuec.api.study_table import StudyTable
from tissuec.studies.table import DIVERGED, DONE, FactorHead, MeasureHead, Row, StudyHead

LIFT = FactorHead("lift", "mm", values="1 mm to 6 mm in 6 steps")


def table_of(design, factors, points, function, *, base=0, measures=("N",), every=None):
    """Return the table of a design whose measures are a function of the values.

    Args:
        design: Name of the design.
        factors: Heads of the factors.
        points: Values of the factors, shape (run, factor).
        function: Returns the measures of a point; None for a run that fails.
        base: Base number of "sobol indices".
        measures: Units of the measures, which are called m0, m1, …
        every: Time between values of a curve, which comes after all measures [s].
    """
    heads = [MeasureHead(f"m{n}", unit) for n, unit in enumerate(measures)]
    if every is not None:
        heads.append(MeasureHead("curve", "N", every))
    rows = []
    for run, point in enumerate(points):
        found = function(*point)
        nothing = (*(np.nan for _ in measures), *(() for _ in heads[len(measures) :]))
        is_done = found is not None
        rows.append(
            Row(
                run,
                tuple(point),
                tuple(found) if is_done else nothing,
                DONE if is_done else DIVERGED,
                "" if is_done else "the motion diverged",
                "kept" if is_done else "not checked",
                1e-6 if is_done else np.nan,
                str(run),
            )
        )
    head = StudyHead("study", "scene", design, 1, base, len(rows), tuple(factors), tuple(heads))
    return StudyTable.of(head, rows)


def grid():
    """Return lifts and words, with one run that failed and a curve for each run."""

    def pull(lift, word):
        if (lift, word) == (6.0, "hard"):
            return None
        force = 1e-3 * lift * (1 if word == "soft" else 3)
        return force, 0.1 * lift, tuple(force * t for t in range(5))

    points = product(np.arange(1.0, 7.0), ("soft", "hard"))
    factors = (LIFT, FactorHead("hardness of liver", "", is_text=True, values="[soft, hard]"))
    return table_of("grid", factors, points, pull, measures=("N", "s"), every=0.1)


def plane():
    """Return a grid of two factors with numbers."""
    points = product(np.arange(1.0, 7.0), np.arange(5.0))
    factors = (LIFT, FactorHead("width", "mm"))
    return table_of("grid", factors, points, lambda x, y: (1e-3 * x * y,))


def sample():
    """Return a random sample of two factors."""
    random = np.random.default_rng(2)
    points = random.normal((5.0, 2.0), (1.0, 0.5), (80, 2)).tolist()
    factors = (LIFT, FactorHead("stiffness of liver", "N/m"))
    return table_of("latin hypercube", factors, points, lambda x, c: (1e-3 * x * c,))


def one_at_a_time():
    """Return a scene with x = 2 mm and c = 10 N/m, and each factor changed by itself."""
    points = [(2.0, 10.0), (1.0, 10.0), (3.0, 10.0), (2.0, 5.0), (2.0, 40.0)]
    factors = (LIFT, FactorHead("stiffness of liver", "N/m"))
    return table_of("one at a time", factors, points, lambda x, c: (1e-3 * x * c,))


def refined():
    """Return methods of order 1, 2 and 4 at steps of ratio 2 and then 4."""
    steps = (8.0, 4.0, 2.0, 0.5)
    points = product(steps, ("one", "two", "four"))
    orders = {"one": 1, "two": 2, "four": 4}
    factors = (FactorHead("step", "ms"), FactorHead("integrator", "", is_text=True))
    return table_of("grid", factors, points, lambda h, name: (1.0 + 1e-3 * h ** orders[name],))


def lossy_sample():
    """Return a random sample of which one run failed."""
    points = [(float(n),) for n in range(100)]
    return table_of("sobol", [LIFT], points, lambda x: None if x == 7.0 else (x,))


def lossy_refinement():
    """Return `refined` with a run of the second method that failed."""

    def measured(h, name):
        return None if (h, name) == (4.0, "two") else (1.0 + 1e-3 * h ** orders[name],)

    orders = {"one": 1, "two": 2, "four": 4}
    factors = (FactorHead("step", "ms"), FactorHead("integrator", "", is_text=True))
    return table_of("grid", factors, product((8.0, 4.0, 2.0, 0.5), orders), measured)


def lossy_effects():
    """Return `one_at_a_time` with a run that failed."""
    points = [(2.0, 10.0), (1.0, 10.0), (3.0, 10.0), (2.0, 5.0), (2.0, 40.0)]
    factors = (LIFT, FactorHead("stiffness of liver", "N/m"))
    return table_of(
        "one at a time", factors, points, lambda x, c: None if c == 40.0 else (1e-3 * x * c,)
    )


def without_effect():
    """Return a study for Sobol indices whose last factor changes nothing."""
    table = indices(base=32)
    points = np.array([factor.numbers for factor in table.factors]).T.tolist()
    return table_of(
        "sobol indices", table.head.factors, points, lambda x, y, z: (x + y,), base=32
    )


def ishigami(x, y, z):
    """Return sin x + 7 sin² y + 0.1 z⁴ sin x (T. Ishigami, T. Homma, 1990)."""
    return np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


def indices(base=256, seed=1, failed=()):
    """Return a study of the Ishigami function with the design "sobol indices".

    Args:
        base: Base number.
        seed: Of the points.
        failed: Numbers of runs that failed.
    """
    from scipy.stats import qmc

    unit = qmc.Sobol(6, scramble=True, seed=np.random.default_rng(seed)).random(base)
    both = np.pi * (2.0 * unit - 1.0)
    blocks = [both[:, :3], both[:, 3:]]
    for place in range(3):
        mixed = blocks[0].copy()
        mixed[:, place] = blocks[1][:, place]
        blocks.append(mixed)
    points = np.concatenate(blocks)
    lost = {tuple(points[run]) for run in failed}
    factors = [FactorHead(name, "") for name in ("x1", "x2", "x3")]
    return table_of(
        "sobol indices", factors, points.tolist(),
        lambda *point: None if point in lost else (float(ishigami(*point)),),
        base=base, measures=("",),
    )  # fmt: skip
