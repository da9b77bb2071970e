"""Abaqus input files: shapes, sets and instances are read; the rest is named and counted."""

import json
import os

import numpy as np
import pytest
from click.testing import CliRunner

from tests.every import every
from tests.imports.test_bombs import peak, refusal
from tissuec.cli import group
from tissuec.core.fields import LocatedFile
from tissuec.core.source import Source
from tissuec.meshes.formats import read
from tissuec.meshes.formats.abaqus import shape_of
from tissuec.meshes.generators.imported import Imported
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

CUBE = ("0, 0, 0", "1, 0, 0", "1, 1, 0", "0, 1, 0", "0, 0, 1", "1, 0, 1", "1, 1, 1", "0, 1, 1")
NODES = "\n".join(f"{k}, {place}" for k, place in enumerate(CUBE, 1))
BRICK = f"*NODE\n{NODES}\n*ELEMENT, TYPE=C3D8, ELSET=TISSUE\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
MIXED = BRICK + (
    "*NODE\n11, 0, 0, 2\n12, 1, 0, 2\n13, 1, 1, 2\n14, 0, 1, 2\n"
    "*ELEMENT, TYPE=S4R, ELSET=PLATE\n2, 11, 12, 13, 14\n"
    "*ELEMENT, TYPE=R3D4, ELSET=PUNCH\n3, 11, 12, 13, 14,\n"
    "*ELEMENT, TYPE=SPRINGA, ELSET=S\n4, 1, 11\n5, 2, 12\n6, 3,\n 13\n"
    "*ELEMENT, TYPE=MASS, ELSET=M\n7, 11\n*ELEMENT, TYPE=COH3D8\n8, 1,2,3,4,5,6,7,8\n"
)


def of(text, path, **entries):
    path.write_text(text)
    return Imported(LocatedFile(path.name, path, 1e-3), **entries)


@every(
    ("names", "shape"),
    {
        "C3D4 C3D4H C3D4T C3D4P AC3D4 DC3D4": ("tetra", 4),
        "C3D10 C3D10H C3D10M C3D10MH C3D10MHT C3D10I C3D10HS": ("tetra", 10),
        "C3D8 C3D8R C3D8H C3D8RH C3D8I C3D8IH C3D8T C3D8RPH EC3D8R": ("hexahedron", 8),
        "C3D20 C3D20RH C3D20RT": ("hexahedron", 20),
        "C3D6 C3D6H": ("wedge", 6),
        "C3D15 C3D15H": ("wedge", 15),
        "C3D5 C3D5H": ("pyramid", 5),
        "S3 S3R S3RS STRI3 M3D3 SFM3D3 R3D3 CPS3 DS3": ("triangle", 3),
        "STRI65 M3D6 CPS6M": ("triangle", 6),
        "S4 S4R S4RS S4RSW S4R5 S4RT M3D4 M3D4R SFM3D4R R3D4 CPS4R": ("quad", 4),
        "S8R S8R5 M3D8R": ("quad", 8),
        "S9R5 M3D9R": ("quad", 9),
        "B31 B33H T3D2 SPRINGA SPRING2 MASS ROTARYI CONN3D2 COH3D8 SC8R CPE4H CAX4H "
        "CIN3D8 GK3D8 PC3D C3D15V SAX1 FRAME3D U1 DASHPOTA": None,
    }.items(),
)
def test_types_are_known_by_their_shape(names, shape):
    assert {name: shape_of(name) for name in names.split()} == dict.fromkeys(
        names.split(), shape
    )


def test_hybrid_elements_are_read(tmp_path):
    text = f"*NODE\n{NODES}\n*ELEMENT, TYPE=C3D4H, ELSET=TISSUE\n1, 1, 2, 4, 5\n"
    (elements,) = of(text, tmp_path / "a.inp").build_elements().elements
    assert elements.shape == "tetrahedron" and len(elements.nodes) == 1


def test_what_is_left_out_is_named_with_its_number(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh = of(MIXED, tmp_path / "a.inp")
    remarks = {
        "1 S4R element besides the solid cells, left out in bodies of elements",
        "3 SPRINGA elements left out",
        "1 MASS element left out",
        "1 COH3D8 element left out",
        "1 R3D4 element left out",
    }
    assert set(mesh.shape.remarks) == remarks
    (elements,) = mesh.build_elements().elements
    assert elements.shape == "hexahedron" and len(elements.nodes) == 1
    assert set(mesh.shape.groups) == {"TISSUE", "PLATE"}

    shown = CliRunner().invoke(group, ["import", "a.inp"])
    assert "12 nodes, a surface of 12 triangles, 1 hexahedron, 3 SPRINGA elements left out" in (
        shown.output
    )
    for remark in remarks:
        assert shown.output.count(remark) == 1, remark
    facts = json.loads(CliRunner().invoke(group, ["import", "a.inp", "--json"]).output)
    assert facts["left_out"]["SPRINGA element"] == 3
    assert facts["elements"] == {"hexahedron": 1, "tetrahedron": 0}
    scene = (
        "language 1\n"
        "tissue gel { Young's modulus = 20 kPa; density = 1000 kg/m^3 }\n"
        'body b { mesh is imported { file "a.inp" in mm }; tissue is gel }\n'
        "environment { gravity = (0, 0, -9.81) m/s^2 }\nsimulate { duration = 1 ms }\n"
    )
    _, warnings = check_request(Request(Source("a.tis", scene, path=tmp_path / "a.tis"), ()))
    (found,) = (one for one in warnings if one.code == "W602")
    assert remarks <= {note.message for note in found.notes}


def test_rigid_faces_alone_are_a_surface(tmp_path):
    text = BRICK[: BRICK.index("*ELEMENT")] + "*ELEMENT, TYPE=R3D4\n1, 1, 2, 3, 4\n"
    assert len(of(text, tmp_path / "a.inp").build().skin) == 2


INSTANCES = f"""*Heading
INCLUDED as text
*Part, name=Block
*Node
{NODES}
*Element, type=C3D8
1, 1, 2, 3, 4, 5, 6, 7, 8
*Nset, nset=floor, generate
1, 4, 1
*Elset, elset=all
1,
*End Part
*Assembly, name=Assembly
*Instance, name=Left, part=Block
*End Instance
*Instance, name=Right, part=BLOCK
3., 0., 0.
3., 0., 0., 3., 0., 1., 90.
*End Instance
*Nset, nset=grip, instance=Left
1, 4, 5, 8
*Nset, nset=grip, instance=Right
2, 3
*Nset, nset=other
Left.1, Right.floor, grip
*End Assembly
"""


def test_instances_keep_their_names_and_places(tmp_path):
    mesh = of(INSTANCES, tmp_path / "a.inp").build()
    assert {name: len(nodes) for name, nodes in mesh.groups.items()} == {
        "Left": 8, "Right": 8, "all": 16, "floor": 8, "grip": 6, "other": 8,
    }  # fmt: skip
    right = 1e3 * mesh.position[mesh.groups["Right"]]
    # Shifted by 3 mm, and then turned by 90 degrees about its own corner: x to y, y to -x.
    assert right.min(axis=0) == pytest.approx([2, 0, 0], abs=1e-12)
    assert right.max(axis=0) == pytest.approx([3, 1, 1], abs=1e-12)
    alone = of(INSTANCES, tmp_path / "a.inp", part="Left").build()
    assert len(alone.position) == 8
    single = INSTANCES[: INSTANCES.index("*Instance, name=Right")] + "*End Assembly\n"
    assert set(of(single, tmp_path / "a.inp").build().groups) == {"all", "floor"}


def test_a_part_without_an_instance_is_named(tmp_path):
    text = INSTANCES.replace(
        "*Assembly,", "*Part, name=Idle\n*Node\n1, 9, 9, 9\n*End Part\n*Assembly,"
    )
    assert 'the part "Idle" has no instance and is left out' in (
        of(text, tmp_path / "a.inp").shape.remarks
    )


def random_model(seed: int) -> str:
    """Return a model of parts and turned instances with sets of all kinds."""
    random = np.random.default_rng(seed)
    lines = ["*HEADING"]
    for part in range(3):
        ids = random.permutation(200)[:30] + 1
        lines += [f"*PART, NAME=P{part}", "*NODE"]
        lines += [
            "{}, {!r}, {!r}, {!r}".format(k, *random.random(3).tolist()) for k in ids.tolist()
        ]
        for kind, size, name in (("C3D4", 4, "t"), ("S4R", 4, "s"), ("C3D20R", 20, "h")):
            lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}{part}")
            for row in range(5):
                nodes = random.choice(ids, size, replace=False).tolist()
                number = 100 * "tsh".index(name) + row + 1
                lines += [f"{number}, {', '.join(map(str, nodes[:11]))}" + "," * (size > 11)]
                lines += [", ".join(map(str, nodes[11:]))] if size > 11 else []
        lines += [f"*NSET, NSET=n{part}", ", ".join(map(str, ids[:7].tolist()))]
        lines += [
            f"*ELSET, ELSET=e{part}, GENERATE",
            "1, 5, 2",
            f"*ELSET, ELSET=f{part}",
            "3, 101,",
        ]
        lines.append("*END PART")
    lines.append("*ASSEMBLY, NAME=A")
    for one in range(5):
        shift, axis = random.normal(size=3).tolist(), random.normal(size=6).tolist()
        lines += [f"*INSTANCE, NAME=I{one}, PART=P{one % 3}", ", ".join(map(repr, shift))]
        lines += [", ".join(map(repr, [*axis, 360.0 * random.random()])), "*END INSTANCE"]
        lines += [f"*ELSET, ELSET=g, INSTANCE=I{one}", "1, 2"]
    return "\n".join([*lines, "*END ASSEMBLY", ""])


@every("seed", range(4))
def test_an_independent_reader_gives_the_same(seed, tmp_path):
    abaqus = pytest.importorskip("meshlane.abaqus._abaqus", reason="needs meshlane")
    path = tmp_path / "a.inp"
    path.write_text(random_model(seed))
    expected, found = abaqus.read(path), read(path.read_bytes(), path)
    # The rotation is computed in another order.
    assert np.abs(found.position - expected.points).max() < 1e-12
    corners = {"tetra": 4, "quad": 4, "hexahedron20": 8}
    cells = [block.data[:, : corners[block.type]] for block in expected.cells]
    assert [cells.nodes.tolist() for cells in found.cells] == [c.tolist() for c in cells]
    starts = np.cumsum([0, *map(len, cells)])
    for name, rows in expected.cell_sets.items():
        numbers = np.concatenate([r + s for r, s in zip(rows, starts[:-1], strict=True)])
        assert set(numbers.tolist()) == set(found.parts[name].tolist()), name
    for name, rows in expected.point_sets.items():
        assert set(rows.tolist()) == set(found.groups[name].tolist()), name
    assert set(found.groups) == set(expected.point_sets)
    assert set(found.parts) == {*expected.cell_sets, *(f"I{k}" for k in range(5))}


@every(
    "line",
    (
        "*INCLUDE, INPUT={}", " *INCLUDE, INPUT={}", "*Include,input={}", "*INC*LUDE, INPUT={}",
        "* INCLUDE,INPUT={}", "*NODE, INPUT={}", "*ELEMENT, TYPE=C3D8, INPUT={}",
        "*INCLUDE,\nINPUT={}",
    ),
)  # fmt: skip
def test_no_other_file_is_opened(line, tmp_path):
    pipe = tmp_path / "pipe"
    if not pipe.exists():
        os.mkfifo(pipe)  # whoever opens it waits for ever
    for text in (f"*HEADING\nx\n{line}\n{BRICK}", f"{BRICK}{line}\n"):
        path = tmp_path / "a.inp"
        path.write_text(text.replace("{}", str(pipe)))
        assert "it includes another file, in line" in refusal(path)
    # Without a star it is text, which nothing follows.
    path.write_text(f"*HEADING\nINCLUDE, INPUT={pipe}\n{BRICK}")
    assert len(Imported(LocatedFile("a.inp", path, 1e-3)).build().position) == 8


@every(
    ("change", "said"),
    [
        (("*NODE\n", "*NODE, SYSTEM=C\n"), "*NODE in line 1 is not supported"),
        (("*ELEMENT", "*NGEN\n1, 5, 1\n*ELEMENT"), "*NGEN in line 10 is not supported"),
        (("2, 1, 0, 0", "2, 1, 0"), '"2, 1, 0" below line 1 cannot be read as a node'),
        (("2, 1, 0, 0", "2, , 0, 0"), "a number cannot be read"),
        (("2, 1, 0, 0", "1, 1, 0, 0"), "duplicate node 1"),
        (("1, 1, 2, 3", "1, 9, 2, 3"), "type C3D8 has node 9, which does not exist"),
        (("7, 8\n", "7\n"), "the elements of type C3D8 below line 10 cannot be read"),
        (("TISSUE\n", "A\n"), ""),
        (("*EL", "*NSET, NSET=x\n1, 99\n*EL"), 'set "x" cannot be read: there is no node 99'),
        (("*EL", "*NSET, NSET=x\nabc\n*EL"), 'there is no set "abc"'),
        (("*EL", "*NSET, NSET=x, GENERATE\n1, 5, 0\n*EL"), "is not first, last and step"),
        (("*EL", "*NSET, NSET=x, INSTANCE=q\n1\n*EL"), 'there is no instance "q"'),
        (("C3D8,", "CPE4H,"), "only 8 nodes and 1 CPE4H element"),
    ],
)  # fmt: skip
def test_broken_files_are_refused_with_their_place(change, said, tmp_path):
    path = tmp_path / "a.inp"
    path.write_text(BRICK.replace(*change, 1))
    if said:
        assert said in refusal(path)
    else:
        Imported(LocatedFile("a.inp", path, 1e-3)).build()


def test_copies_of_parts_and_ranges_have_little_room(tmp_path):
    """A file of 270 kB declares 20 million nodes, and ranges a billion numbers."""
    path = tmp_path / "a.inp"
    nodes = "\n".join(f"{k}, {k}, 0, 0" for k in range(1, 5001))
    copies = "\n".join(f"*INSTANCE, NAME=I{k}, PART=P\n*END INSTANCE" for k in range(4000))
    part = f"*PART, NAME=P\n*NODE\n{nodes}\n*END PART\n*ASSEMBLY\n"
    path.write_text(f"{part}{copies}\n*END ASSEMBLY\n")
    assert peak(lambda: refusal(path)) < 400 << 20
    assert "its instances take more than 129 MiB" in refusal(path)
    ends = range(2000, 5001)
    ranges = "\n".join(f"{low}, {high}, 1" for low in (1, 2) for high in ends)
    path.write_text(f"*NODE\n{nodes}\n*NSET, NSET=a, GENERATE\n{ranges}\n")
    assert "its sets take more than 129 MiB" in refusal(path)
    path.write_text(f"{BRICK}*NSET, NSET=a, GENERATE\n1, 999999999999999, 1\n")
    mesh = Imported(LocatedFile("a.inp", path, 1e-3))
    assert peak(lambda: mesh.build()) < 16 << 20
    assert len(mesh.shape.groups["a"]) == 8
