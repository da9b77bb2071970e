"""Readers of H5MD 1.1 find what its specification promises."""

import h5py
import numpy as np
import pytest


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("finished", [True, False])
def test_the_view_has_the_layout_of_the_specification(tmp_path, example, single, finished):
    example = example.recorded(single=single)
    with example.open(tmp_path / "a.vtkhdf", author="A. Surgeon") as writer:
        example.write(writer)
        path = writer.close("done", finished=finished)
    kind = np.dtype("f4" if single else "f8")
    with h5py.File(path, "r") as file:
        head = file["h5md"]
        assert head.attrs["version"].tolist() == [1, 1]
        assert head["author"].attrs["name"] == "A. Surgeon"
        assert head["creator"].attrs["name"] == "tissuec"
        assert isinstance(head["creator"].attrs["version"], str)
        particles = file["particles/all"]
        box = particles["box"]
        assert box.attrs["dimension"] == 3
        assert box.attrs["boundary"].tolist() == [b"none"] * 3
        for name in ("position", "velocity", "force"):
            element = particles[name]
            assert set(element) == {"value", "time", "step"}
            expected = getattr(example, name)
            assert element["value"].is_virtual
            assert element["value"].dtype == kind
            assert np.array_equal(element["value"][:], expected.astype(kind))
            assert np.array_equal(element["value"][7, 3:5], expected[7, 3:5].astype(kind))
            assert np.array_equal(element["time"][:], example.time)
            assert np.array_equal(element["step"][:], np.arange(len(example.time)))
        assert np.array_equal(particles["mass"][:], example.network.mass)


def test_the_views_take_no_space_for_numbers(tmp_path, example):
    with h5py.File(example.saved(tmp_path / "a.vtkhdf"), "r") as file:
        source = file["particles/all/position/value"].virtual_sources()
        assert [(s.file_name, s.dset_name) for s in source] == [(".", "/VTKHDF/Points")]


def test_the_views_survive_a_change_of_the_file_name(tmp_path, example):
    path = example.saved(tmp_path / "a.vtkhdf").rename(tmp_path / "b.h5")
    with h5py.File(path, "r") as file:
        value = file["particles/all/position/value"]
        assert np.array_equal(value[:], example.position)
