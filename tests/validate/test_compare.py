"""How errors are counted: what they are relative to, and where nothing can be said."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene, rod, silent
from tissuec.validate.compare import (
    Miss,
    between_events,
    force_groups,
    match,
    missed,
    support_forces,
)
from tissuec.validate.engine_run import observe
from tissuec.validate.reference import reference
from tissuec.validate.uncertainty import known_reference, relative_positions

TIMES = np.linspace(0.0, 0.15, 31)


def both():
    scene = compiled_scene(rod())
    run = observe(scene.network, scene.plan, TIMES, lambda time: None)
    return scene, run, reference(scene.network, scene.plan, TIMES)


def test_rows_at_which_an_event_has_happened_in_one_solution_only_do_not_count():
    times = np.linspace(0.0, 0.3, 31)
    apart = between_events(times, {3: 0.0999, 4: 0.2}, {3: 0.1201, 4: 0.2}, 0.3)
    assert times[apart] == pytest.approx([0.1, 0.11, 0.12, 0.2])
    scene, run, solution = both()
    run.force[12] += 1.0
    state, groups = run.outcome.state, force_groups(scene.plan, solution)
    for valid, large in ((np.ones(31, dtype=bool), True), (np.arange(31) != 12, False)):
        found = support_forces(run, solution, state, groups, valid, None)
        assert all((quantity.error > 1.0) is large for quantity in found)


def test_largest_energy_so_far_never_falls():
    _, run, solution = both()
    assert (np.diff(run.scale) >= 0.0).all()
    sizes = np.abs(solution.energies[:, [0, 3, 4, 5]]).max(axis=1)
    assert (run.scale >= 0.999 * np.maximum.accumulate(sizes)).all()


def test_second_reference_begins_from_another_rounding():
    scene = compiled_scene(rod(extra="at 0 s: change rest length of rod by 90 %"))
    known = known_reference(
        scene.network, scene.plan, TIMES, method="DOP853", rtol=1e-9, progress=silent
    )
    first, second = known.reference.initial, known.second.initial
    assert first != second
    assert first == pytest.approx(second, rel=1e-12)


def test_errors_of_positions_are_relative_to_the_largest_displacement_so_far():
    network = compiled_scene(rod()).network  # 30 mm long
    errors = relative_positions(np.array([1e-6, 1e-6]), np.array([0.0, 1e-2]), network)
    assert errors == pytest.approx([1e-6 / 30e-9, 1e-4], rel=1e-6)
    assert relative_positions(np.array([1e-17]), np.array([0.0]), network) == [0.0]


def test_order_of_events_is_told_but_not_that_of_simultaneous_ones():
    late, early = {1: 0.1, 2: 0.2}, {1: 0.2, 2: 0.1}
    assert match(late, late, [], 1.0).in_order
    assert not match(late, early, [], 1.0).in_order
    assert match(late, early, [], 1.0).error == pytest.approx(0.1)
    assert match({1: 0.1, 2: 0.1 + 1e-12}, {1: 0.1 + 1e-12, 2: 0.1}, [], 1.0).in_order


def test_events_of_one_solution_only_are_missed_in_the_other():
    misses = missed({1: 0.1, 2: 0.2}, {2: 0.2, 3: 0.05})
    assert misses == [Miss(1, 0.1, True), Miss(3, 0.05, False)]
    found = match({1: 0.1, 2: 0.2}, {2: 0.2, 3: 0.05}, misses, 1.0)
    assert [miss.number for miss in found.misses] == [3, 1]
    assert not found.in_order
