"""Scenes with organs from files: sets, pressure, results, and what a file leaves in them."""

import json
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests.imports.organs import blob, write_obj
from tissuec.cli import group
from tissuec.compiler.prediction import predict
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.units import TIME, show
from tissuec.geometry.edges import volume
from tissuec.meshes.generators.lattice import Lattice
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

SCENE = """\
language 1
tissue gum {{ spring constant = 40 N/m; viscosity = 0.02 N*s/m; mass = 100 mg }}
tissue lump like gum {{ spring constant = 80 N/m; viscosity = 0.04 N*s/m }}
body organ {{ {body} }}
set low = nodes of organ where z < 90 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix low {script} }}
simulate {{ duration = 20 ms }}
output {{ trajectory every 5 ms; {output} }}
"""


def scene(folder: Path, body: str, *, script: str = "", output: str = "") -> Request:
    path = folder / "organ.tis"
    path.write_text(SCENE.format(body=body, script=script, output=output))
    return Request.file(path)


@pytest.fixture
def organ(tmp_path: Path) -> Path:
    write_obj(tmp_path / "organ.obj", *blob(2), "tumour")
    return tmp_path


def test_regions_and_sets_by_group(organ: Path) -> None:
    request = scene(
        organ,
        """mesh is imported { file "organ.obj" in mm; filling is sodium chloride; cell = 14 mm }
        tissue is gum
        region hard where group is tumour { tissue is lump }
        region rest where surface and not region is hard { tissue is gum }
        interface is stiffer""".replace(
            " and not region is hard", ' and group is not "TUMOUR"'
        ),
    )
    compiled, warnings = compile_request(request)
    assert [w.code for w in warnings] == []
    part = compiled.groups.bodies["organ"].drawing.part
    expected = np.unique(blob(2)[1][160:])
    assert np.array_equal(np.flatnonzero(part == 1), expected)
    assert (part == 0).sum() == len(part) - 162
    stiff = np.isin(compiled.network.springs.ends, expected).any(axis=1)
    assert np.array_equal(compiled.network.springs.stiffness == 80.0, stiff)


def test_shares_multiply_spring_constant_and_viscosity_and_say_so(organ: Path) -> None:
    body = (
        """mesh is imported { file "organ.obj" in mm; stiffness is area rule }; tissue is gum"""
    )
    network = compile_request(scene(organ, body))[0].network
    assert network.springs.stiffness.std() > 1.0
    assert network.springs.damping == pytest.approx(
        network.springs.stiffness * 0.02 / 40.0, rel=1e-12
    )
    assert network.provenance["stiffness"][0].how == "written, shared"


def test_pressure_works_on_an_imported_surface(organ: Path) -> None:
    request = scene(
        organ,
        'mesh is imported { file "organ.obj" in mm }; tissue is gum',
        script="\n at 0 s: preserve volume of organ with firm pressure",
        output="volume of organ every 5 ms",
    )
    compiled, _ = compile_request(request)
    result = simulate(compiled, organ / "a.vtkhdf", request=request)
    assert result.outcome.kind == "done"
    with Trajectory.open(result.path) as trajectory:
        held = trajectory.logs["volume of organ"].value.ravel()
    assert held[0] == pytest.approx(1e-9 * volume(*blob(2)), rel=1e-9)


def test_a_result_holds_the_digest_of_the_mesh_file(organ: Path) -> None:
    request = scene(organ, 'mesh is imported { file "organ.obj" in mm }; tissue is gum')
    compiled, _ = compile_request(request)
    simulate(compiled, organ / "a.vtkhdf", request=request)
    with Trajectory.open(organ / "a.vtkhdf") as trajectory:
        files = trajectory.manifest["files"]
    assert files == {"organ.obj": sha256((organ / "organ.obj").read_bytes()).hexdigest()}


def test_a_scene_that_is_no_file_finds_what_is_in_a_library_only() -> None:
    text = SCENE.format(
        body='mesh is imported { file "meshes/liver.obj" in mm }; tissue is gum',
        script="",
        output="",
    ).replace("z < 90 mm", "z < 0 mm")
    compiled, _ = compile_request(Request(Source("x.tis", text)))
    assert compiled.network.node_count == 642
    with pytest.raises(CompileError, match="there is no file"):
        compile_request(Request(Source("x.tis", text.replace("liver.obj", "lung.obj"))))


def test_two_runs_give_the_same_bytes(organ: Path) -> None:
    body = """mesh is imported { file "organ.obj" in mm; filling is diamond; cell = 20 mm
        reach is second neighbours; stiffness is area rule }; tissue is gum"""
    one, other = (compile_request(scene(organ, body))[0].network for _ in range(2))
    for name in ("position", "ends", "stiffness", "skin"):
        assert one.array(name).tobytes() == other.array(name).tobytes()


def test_import_prints_a_scene_that_passes_the_check(organ: Path) -> None:
    def inside(*words: str) -> Result:
        return CliRunner().invoke(group, [*words], standalone_mode=False)

    def tissuec(*words: str) -> subprocess.CompletedProcess:
        return subprocess.run(
            [sys.executable, "-m", "tissuec", *words], cwd=organ, capture_output=True, text=True
        )

    said = tissuec("import", "organ.obj")
    assert said.returncode == 0, said.stderr
    assert "# 162 nodes, a surface of 320 triangles" in said.stdout
    (organ / "made.tis").write_text(said.stdout)
    checked = inside("check", "--strict", str(organ / "made.tis"))
    assert checked.return_value == 0, checked.output
    compiled, _ = compile_request(Request.file(organ / "made.tis"))
    seconds = predict(compiled).seconds
    assert seconds < 10.0
    shown = f"{show(seconds, TIME, digits=2)} of processor time"
    assert (shown in said.stderr) == (seconds > 3.0)
    own = json.loads(inside("import", str(organ / "organ.obj"), "--json").stdout)
    assert own["seconds"] == pytest.approx(seconds)
    facts = json.loads(
        inside("import", str(organ / "organ.obj"), "--unit", "cm", "--json").stdout
    )
    assert facts["closed"] and facts["groups"]["tumour"] > 80
    assert facts["volume"] == pytest.approx(1e-6 * volume(*blob(2)), rel=1e-9)
    assert tissuec("import", "organ.obj", "--unit", "kg").returncode == 2
    assert "no such file" in tissuec("import", "orgam.obj").stderr


def imported(folder: Path, points: np.ndarray, *words: str) -> Result:
    """Import a box whose corners are those of the unit cube, moved to other places."""
    corners = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
    faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    (folder / "box.obj").write_text(corners + faces)
    command = ["import", str(folder / "box.obj"), *words]
    return CliRunner().invoke(group, command, standalone_mode=False)


CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])


@pytest.mark.parametrize(
    ("thickness", "is_filled"),
    [
        (25.0, True),
        pytest.param(5.0, True, marks=pytest.mark.slow),
        pytest.param(0.2, False, marks=pytest.mark.slow),
    ],
)
def test_a_filling_of_a_flat_part_is_as_coarse_as_its_box_or_left_out(
    thickness: float, is_filled: bool, tmp_path: Path
) -> None:
    done = imported(tmp_path, CUBE * (100.0, 80.0, thickness))
    (tmp_path / "made.tis").write_text(done.stdout)
    assert ("filling is" in done.stdout) is is_filled
    assert ("its walls are thin" in done.stdout) is not is_filled
    compiled, _ = compile_request(Request.file(tmp_path / "made.tis"))
    assert compiled.network.node_count <= 40_000 + 8


@pytest.mark.parametrize(("large", "unit"), [(0.16, "m"), (1.6e5, "um"), (160.0, None)])
def test_an_organ_of_the_size_of_a_crumb_or_a_house_is_asked_about(
    tmp_path: Path, large: float, unit: str | None
) -> None:
    done = imported(tmp_path, CUBE * large)
    if unit is None:
        assert not done.stderr
    else:
        assert done.stderr.startswith("warning: the mesh is ")
        assert done.stderr.endswith(f"if it is 160 mm large, write: --unit {unit}\n")
        assert not imported(tmp_path, CUBE * large, "--unit", unit).stderr


def test_the_shipped_organ_is_what_its_script_writes(repository: Path) -> None:
    space: dict = {"__file__": str(repository / "docs" / "make_organ.py"), "__name__": "organ"}
    script = (repository / "docs" / "make_organ.py").read_text(encoding="utf-8")
    exec(compile(script, "make_organ.py", "exec"), space)
    shipped = (repository / "library" / "meshes" / "liver.obj").read_text(encoding="utf-8")
    assert space["organ"]() == shipped


def test_a_cubic_lattice_with_equal_face_diagonals_is_isotropic() -> None:
    """What the scene of the liver takes its spring constant from: E = 2.5 c / a."""
    size = 12
    lattice = Lattice(
        "sodium chloride", 1.0, (np.zeros(3), np.full(3, float(size))), "second neighbours"
    ).build()
    middle = lattice.position[lattice.ends].mean(axis=1)
    whole = ((middle >= 2.0) & (middle < size - 2.0)).all(axis=1)
    way = np.diff(lattice.position[lattice.ends[whole]], axis=1)[:, 0]
    unit = way / np.linalg.norm(way, axis=1, keepdims=True)
    energy = np.einsum("s,si,sj,sk,sl->ijkl", (way**2).sum(axis=1), unit, unit, unit, unit)
    c = energy / (size - 4.0) ** 3  # stiffness tensor for a constant of 1 and a cell of 1
    assert c[0, 0, 0, 0] - c[0, 0, 1, 1] == pytest.approx(2 * c[0, 1, 0, 1], rel=1e-12)
    lam, mu = c[0, 0, 1, 1], c[0, 1, 0, 1]
    assert mu * (3 * lam + 2 * mu) / (lam + mu) == pytest.approx(2.5, rel=1e-12)
    assert lam / (2 * (lam + mu)) == pytest.approx(0.25, rel=1e-12)
