"""Label images: volumes, places and names in lattices and surfaces, or a reason why not."""

import gzip
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.every import every
from tests.imports.images import (
    BALL,
    CENTRE,
    NAMES,
    RADIUS,
    TURNED,
    ball,
    segments,
    write_nifti,
    write_nrrd,
)
from tissuec.cli import group
from tissuec.core.errors import CompileError
from tissuec.core.fields import LocatedFile
from tissuec.core.source import Source
from tissuec.geometry.edges import Edges, volume
from tissuec.meshes.generators.imported import Imported, MeshFileError
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

for name in ("nrrd", "nibabel", "skimage"):
    pytest.importorskip(name, reason="needs the images extra")

BALLS = {
    "even": ((1.0, 1.0, 1.0), None, False),
    "uneven": ((0.8, 1.0, 2.0), None, False),
    "turned": ((1.0, 1.0, 1.0), TURNED, False),
    "uneven turned mirrored": ((0.7, 0.9, 1.3), TURNED, True),
}


def imported(path: Path, factor=1e-3, **entries):
    """Return the mesh of a file in millimetres."""
    return Imported(LocatedFile(path.name, path, factor), **entries).build()


def refusal(path: Path, **entries) -> str:
    with pytest.raises(MeshFileError) as caught:
        imported(path, **entries)
    return f"{caught.value} | {caught.value.hint}"


def centre_of(mesh):
    """Return the centre of the volume inside the skin [mm], shape (3,)."""
    a, b, c = mesh.position[mesh.skin].swapaxes(0, 1)
    content = np.einsum("ij,ij->i", a, np.cross(b, c))
    return 1e3 * content @ (a + b + c) / 4.0 / content.sum()


def inside_of(mesh) -> float:
    """Return the volume inside the skin [mm³]; negative if it faces inwards."""
    return 1e9 * volume(mesh.position, mesh.skin.astype(np.int64))


def is_closed(mesh) -> bool:
    return Edges.among(mesh.skin.astype(np.int64)).is_closed


MESHES = (
    {},
    {"resolution": 3e-3},
    {"filling": "cubes", "cell": 1e-3},
    {"filling": "sodium chloride", "cell": 3e-3},
)


CASES = [
    (kind, form, entries)
    for entries in MESHES
    for kind, form in (*((kind, "r") for kind in BALLS), ("uneven turned mirrored", "n"))
]


@every(("kind", "form", "entries"), CASES, parts=4)
def test_a_ball_has_its_volume_and_its_place(kind, form, entries, tmp_path):
    path = tmp_path / (f"{kind}.nrrd" if form == "r" else f"{kind}.nii.gz")
    labels, axes, origin = ball(*BALLS[kind])
    (write_nrrd if form == "r" else write_nifti)(path, labels, axes, origin)
    mesh = imported(path, **entries)
    assert is_closed(mesh)
    assert inside_of(mesh) == pytest.approx(BALL, rel=0.02)
    assert np.abs(centre_of(mesh) - CENTRE).max() < 0.5 * min(BALLS[kind][0])
    if entries.get("filling") != "cubes":
        far = np.linalg.norm(1e3 * mesh.position[np.unique(mesh.skin)] - CENTRE, axis=1)
        assert np.abs(far - RADIUS).max() < 0.71 * max(BALLS[kind][0])
    left = 1e3 * mesh.position[mesh.groups["label 2"]] @ (1.0, 0.0, 0.0) - CENTRE[0]
    right = 1e3 * mesh.position[mesh.groups["label 1"]] @ (1.0, 0.0, 0.0) - CENTRE[0]
    assert left.min() > -2.0 and right.max() < 2.0
    assert not np.intersect1d(mesh.groups["label 1"], mesh.groups["label 2"]).size
    assert sum(map(len, mesh.groups.values())) == len(mesh.position)


@every("entries", ({}, {"filling": "cubes", "cell": 2e-3}))
def test_both_formats_and_all_spaces_give_the_same_coordinates(entries, tmp_path):
    labels, axes, origin = ball((0.8, 1.0, 2.0))
    labels[:20] = 0  # nothing is symmetric
    write_nrrd(tmp_path / "lps.nrrd", labels, axes, origin)
    expected = imported(tmp_path / "lps.nrrd", **entries)
    write_nifti(tmp_path / "image.nii", labels, axes, origin)
    write_nifti(tmp_path / "micron.nii.gz", labels, 1e3 * axes, 1e3 * origin, unit="micron")
    for space, signs in (("RAS", (-1, -1, 1)), ("left-anterior-superior", (1, -1, 1))):
        turned = np.array(signs)[:, None] * axes, np.array(signs) * origin
        write_nrrd(tmp_path / f"{space}.nrrd", labels, *turned, space=space)
    for path in tmp_path.iterdir():
        mesh = imported(path, 1e-6 if path.stem.startswith("micron") else 1e-3, **entries)
        # NIfTI holds single precision: 40 mm to 24 bits.
        assert mesh.position == pytest.approx(expected.position, abs=1e-8), path.name
        assert (mesh.skin == expected.skin).all(), path.name


def test_one_voxel_is_where_the_header_says(tmp_path):
    labels = np.zeros((4, 5, 6), np.uint8)
    labels[3, 0, 4] = 7
    axes, origin = np.diag([2.0, 3.0, -5.0]), np.array([100.0, 200.0, 300.0])
    write_nrrd(tmp_path / "one.nrrd", labels, axes, origin)
    mesh = imported(tmp_path / "one.nrrd")
    assert centre_of(mesh) == pytest.approx([106.0, 200.0, 280.0], abs=1e-6)
    cubes = imported(tmp_path / "one.nrrd", filling="cubes", cell=1e-3)
    assert 1e3 * cubes.position.min(axis=0) == pytest.approx([105.0, 198.5, 277.5], abs=0.5001)
    assert 1e3 * cubes.position.max(axis=0) == pytest.approx([107.0, 201.5, 282.5], abs=0.5001)
    assert list(mesh.groups) == ["label 7"]


@pytest.mark.parametrize("filling", ["none", "cubes"])
def test_any_labels_at_any_border_have_a_closed_surface(filling, tmp_path):
    random = np.random.default_rng(3)
    for share in (0.1, 0.3, 0.5, 0.7, 1.0):
        labels = (random.random((7, 8, 9)) < share).astype(np.uint8)
        write_nrrd(tmp_path / "any.nrrd", labels, np.eye(3), np.zeros(3))
        entries = {"cell": 1e-3} if filling == "cubes" else {}
        mesh = imported(tmp_path / "any.nrrd", filling=filling, **entries)
        assert is_closed(mesh)
        assert inside_of(mesh) > 0.0
        if share == 1.0:
            # Corners are rounded by half a voxel at most.
            assert inside_of(mesh) == pytest.approx(7 * 8 * 9, rel=0.02)


def test_segments_have_the_names_of_3d_slicer_and_are_parts(tmp_path):
    path = tmp_path / "ball.seg.nrrd"
    write_nrrd(path, *ball((1.0, 1.0, 1.0)), more=segments((*NAMES, "cyst")))
    mesh = imported(path, filling="cubes", cell=2e-3)
    assert list(mesh.groups) == list(NAMES)
    assert mesh.remarks == ('no voxel is labelled "cyst"',)
    half = imported(path, part="Tumör")
    assert inside_of(half) == pytest.approx(BALL / 2.0, rel=0.02)
    assert half.position[:, 0].min() > 1e-3 * (CENTRE[0] - 1.0)
    assert '"Tumor" is not a part of it | did you mean "Tumör"' in refusal(path, part="Tumor")


def test_labels_of_a_thin_layer_keep_their_nodes_and_lost_ones_are_named(tmp_path):
    labels = np.ones((20, 20, 20), np.uint8)
    labels[:, :, 9:11] = 2
    labels[3, 4, 3] = 5
    labels[13:15, 13:15, 13:15] = 6
    write_nrrd(tmp_path / "layers.nrrd", labels, np.eye(3), np.zeros(3))
    mesh = imported(tmp_path / "layers.nrrd", filling="cubes", cell=2e-3)
    assert len(mesh.groups["label 2"]) > 100
    assert len(mesh.groups["label 6"]) == 8
    assert '1 part too small for the cell: "label 5"' in mesh.remarks
    fine = imported(tmp_path / "layers.nrrd", filling="cubes", cell=1e-3)
    assert len(fine.groups["label 2"]) == 3 * 21 * 21
    assert len(fine.groups["label 6"]) == 7  # in the middle, and in the middle of six faces
    assert len(fine.groups["label 5"]) == 8


def test_a_label_by_its_number_is_answered_with_its_part(tmp_path):
    write_nrrd(tmp_path / "a.nrrd", SMALL, *PLACE)
    body = 'mesh is imported { file "a.nrrd" in mm; label = 1 }; tissue is silk'
    scene = f"language 1\ntissue silk {{ mass = 1 mg }}\nbody b {{ {body} }}\n"
    source = Source("a.tis", scene, tmp_path / "a.tis")
    with pytest.raises(CompileError) as caught:
        check_request(Request(source))
    hints = [str(one.hint) for one in caught.value.diagnostics if one.code == "TIS303"]
    assert hints == [hints[0]] and hints[0].startswith('write part "label 1"  entries: ')


def test_a_large_image_is_read_without_copies_in_double_precision(tmp_path):
    side = 192
    line = np.arange(side) - side / 2
    square = line.astype(np.float32) ** 2
    labels = (square[:, None, None] + square[:, None] + square < 80.0**2).astype(np.uint8)
    write_nrrd(tmp_path / "large.nrrd", labels, np.eye(3), np.zeros(3))
    tracemalloc.start()
    mesh = imported(tmp_path / "large.nrrd", filling="cubes", cell=16e-3)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(mesh.position) > 300
    assert most < 5 * side**3  # bytes; a copy of eight for each voxel has no room


def test_what_is_too_coarse_is_reported(tmp_path):
    write_nrrd(tmp_path / "ball.nrrd", *ball((1.0, 1.0, 1.0)))
    (remark,) = imported(tmp_path / "ball.nrrd", resolution=16e-3).remarks
    assert remark.startswith("the surface encloses ")
    remarks = imported(tmp_path / "ball.nrrd", filling="cubes", cell=20e-3).remarks
    assert any(remark.startswith("cubes take ") for remark in remarks)


def test_import_proposes_a_scene_that_is_good(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_nrrd(tmp_path / "ball.seg.nrrd", *ball((0.8, 1.0, 2.0)), more=segments())
    said = CliRunner().invoke(group, ["import", "ball.seg.nrrd"])
    assert said.exit_code == 0, said.output
    assert "# 50 x 40 x 20 voxels of 800 um x 1 mm x 2 mm; in cubes:" in said.output
    assert '# part "Tumör": ' in said.output
    scene = said.output.replace("# region", "region").replace("…", "liver")
    (tmp_path / "organ.tis").write_text(scene.replace("# interface", "interface"), "utf-8")
    said = CliRunner().invoke(group, ["check", "organ.tis"])
    assert said.exit_code == 0, said.output


SEGMENTS = {
    "two of a name": (("liver", "liver"), (), "the labels 1 and 2 have the same name"),
    "name of a number": (("label 2", ""), (), 'have the same name, "label 2"'),
    "a word": (NAMES, ("2", "two"), '"two" is not a label, in Segment1_LabelValue'),
    "background": (NAMES, ("2", "0"), '"0" is not a label'),
    "two of a label": (NAMES, ("2", "1"), 'the label 1 has two names, "liver" and "Tumör"'),
}


@every("case", SEGMENTS)
def test_segments_whose_names_are_not_clear_are_refused(case, tmp_path):
    names, value, reason = SEGMENTS[case]
    more = [line.replace(*map("={}".format, value)) if value else line
            for line in segments(names)]  # fmt: skip
    write_nrrd(tmp_path / "a.seg.nrrd", *ball((2.0, 2.0, 2.0)), more=more)
    said = refusal(tmp_path / "a.seg.nrrd")
    assert reason in said and "again" in said


def test_a_segment_without_a_label_is_reported(tmp_path):
    more = [line for line in segments() if not line.startswith("Segment1_LabelValue")]
    write_nrrd(tmp_path / "a.seg.nrrd", *ball((2.0, 2.0, 2.0)), more=more)
    mesh = imported(tmp_path / "a.seg.nrrd")
    assert list(mesh.groups) == ["liver", "label 2"]
    assert mesh.remarks == ('the segment "Tumör" is not used: it has no Segment1_LabelValue',)


def test_a_resolution_that_voxels_do_not_have_is_refused(tmp_path):
    write_nrrd(tmp_path / "a.nrrd", *ball((1.0, 1.0, 2.0)))
    said = refusal(tmp_path / "a.nrrd", resolution=0.9e-3)
    assert "below the size of its voxels, 1 mm x 1 mm x 2 mm" in said
    assert not imported(tmp_path / "a.nrrd", resolution=1e-3).remarks


def said_about(file: str, folder: Path):
    """Return what is said about a scene with a file in mm, and by ``import``."""
    body = f'mesh is imported {{ file "{file}" in mm }}; tissue is silk'
    scene = f"language 1\ntissue silk {{ mass = 1 mg }}\nbody b {{ {body} }}\n"
    with pytest.raises(CompileError) as caught:
        check_request(Request(Source("a.tis", scene, folder / "a.tis")))
    (found,) = (one for one in caught.value.diagnostics if one.code in ("TIS604", "TIS605"))
    return found, str(CliRunner().invoke(group, ["import", str(folder / file)]).exception)


def test_another_unit_is_answered_with_that_of_the_file(tmp_path):
    more = ['space units: "cm" "cm" "cm"']
    write_nrrd(tmp_path / "a.nrrd", *ball((2.0, 2.0, 2.0)), more=more)
    found, shown = said_about("a.nrrd", tmp_path)
    assert found.hint == 'write: file "a.nrrd" in cm'
    assert [(one.text, one.span.text) for one in found.edits] == [
        ('file "a.nrrd" in cm', 'file "a.nrrd" in mm')
    ]
    assert "is cm, not mm; write: --unit cm" in shown


@every("file", ("a.mha", "a.mhd", "IM0001", "series"))
def test_images_of_other_formats_are_answered_with_a_way(file, tmp_path):
    (tmp_path / "series").mkdir(exist_ok=True)
    for name in ("a.mha", "a.mhd", "IM0001", "series/IM0001"):
        content = b"ObjectType = Image" if name.startswith("a.") else bytes(128) + b"DICM"
        (tmp_path / name).write_bytes(content)
    found, shown = said_about(file, tmp_path)
    for said in (found.hint, shown):
        assert "in 3D Slicer" in said and '.nrrd"' in said


def test_wrong_words_of_a_label_image_are_refused(tmp_path):
    image, mesh = (LocatedFile(name, tmp_path / name, 1e-3) for name in ("a.nii.gz", "a.obj"))
    for file, entries, reason in (
        (mesh, {"filling": "cubes", "cell": 1e-3}, "cubes are made of label images"),
        (mesh, {"resolution": 1e-3}, '"resolution" belongs to label images'),
        (image, {"filling": "cubes"}, 'it needs the size of a "cell"'),
        (image, {"cell": 1e-3}, "there is no filling, such as cubes"),
        (image, {"filling": "cubes", "cell": 1e-3, "resolution": 1e-3}, "cubes do not need"),
        (image, {"merging": "off"}, "no nodes that could be merged"),
    ):
        with pytest.raises(ValueError, match=reason):
            Imported(file, **entries)


def changed(path: Path, old: bytes, new: bytes) -> None:
    """Change a header once."""
    data = path.read_bytes()
    assert data.count(old) == 1
    path.write_bytes(data.replace(old, new))


SMALL = np.zeros((4, 4, 4), np.uint8)
SMALL[1:3, 1:3, 1:3] = 1
PLACE = np.eye(3), np.zeros(3)

HEADERS = {
    "no voxel size": (
        b"space directions: (1.0,0.0,0.0) (0.0,1.0,0.0) (0.0,0.0,1.0)\n",
        b"",
        "it does not say how large its voxels are",
    ),
    "flat voxels": (b"(0.0,0.0,1.0)", b"(1.0,1.0,0.0)", "lie in one plane"),
    "empty voxels": (b"(0.0,0.0,1.0)", b"(0.0,0.0,0.0)", "the size of its voxels is 0"),
    "infinite": (b"(0.0,0.0,1.0)", b"(0.0,0.0,inf)", "is not finite"),
    "two numbers": (b"(0.0,0.0,1.0)", b"(0.0,1.0)", "cannot be read"),
    "unknown space": (b"left-posterior-superior", b"3D-left-handed", 'its space is "3D-left'),
    "other unit": (b"endian", b'space units: "um" "um" "um"\nendian', "is um, not mm"),
    "strange unit": (b"endian", b'space units: "ell" "ell" "ell"\nendian', "unknown: ell"),
    "unit of time": (b"endian", b'space units: "s" "s" "s"\nendian', "unknown: s | correct"),
    "more voxels": (b"sizes: 4 4 4", b"sizes: 4 4 5", "it is truncated, or its sizes"),
    "huge": (b"sizes: 4 4 4", b"sizes: 4 4 400000000000", "take more than 2048 MiB"),
    "no size": (b"sizes: 4 4 4", b"sizes: 4 0 4", "its size is 4 x 0 x 4"),
    "vectors": (b"type: uint8", b"type: block", 'of the type "block"'),
    "strange line": (b"endian: little", b"endian little", "its header cannot be read"),
    "elsewhere": (b"endian", b"data file: ../a.raw\nendian", "not one file beside it"),
    "missing data": (b"endian", b"data file: a.raw\nendian", 'is missing: "a.raw"'),
}


@every("case", HEADERS)
def test_what_is_wrong_in_a_header_is_said(case, tmp_path):
    old, new, reason = HEADERS[case]
    path = tmp_path / f"{case}.nrrd"
    write_nrrd(path, SMALL, *PLACE)
    assert is_closed(imported(path))
    changed(path, old, new)
    assert reason in refusal(path)


def picture():
    return np.arange(-500, 500, dtype=np.int16).reshape(10, 10, 10)


VALUES = {
    "a picture": (picture(), "it is a picture, not an image of labels"),
    "empty": (0 * SMALL, "it contains no labelled voxel"),
    "fractions": (0.5 * SMALL.astype(np.float32), "not whole numbers"),
    "gaps": (np.where(SMALL, np.nan, 0).astype(np.float32), "are not finite"),
    "negative": (-SMALL.astype(np.int16), "the label -1"),
}


@every("case", VALUES)
def test_what_is_no_label_is_refused(case, tmp_path):
    values, reason = VALUES[case]
    write_nrrd(tmp_path / "a.nrrd", values, *PLACE)
    write_nifti(tmp_path / "a.nii", values, *PLACE)
    for path in tmp_path.glob("a.*"):
        assert reason in refusal(path)


def test_whole_numbers_of_floating_point_and_single_layers_are_labels(tmp_path):
    for values in (SMALL.astype(np.float32), SMALL.astype(np.uint16), SMALL[None]):
        write_nrrd(tmp_path / "a.nrrd", values, *PLACE)
        assert inside_of(imported(tmp_path / "a.nrrd")) == pytest.approx(8.0, rel=0.02)
    write_nifti(tmp_path / "a.nii.gz", SMALL.astype(np.float32)[..., None], *PLACE)
    assert inside_of(imported(tmp_path / "a.nii.gz")) == pytest.approx(8.0, rel=0.02)


def test_several_layers_or_times_are_refused(tmp_path):
    write_nrrd(tmp_path / "a.nrrd", np.stack([SMALL, SMALL]), *PLACE)
    assert "it contains 2 layers, but one is needed" in refusal(tmp_path / "a.nrrd")
    write_nifti(tmp_path / "a.nii", np.stack([SMALL] * 3, axis=3), *PLACE)
    assert "it contains 3 time steps, but one is needed" in refusal(tmp_path / "a.nii")


def test_headers_of_nifti_that_say_too_little_are_refused_or_reported(tmp_path):
    path = tmp_path / "a.nii"
    write_nifti(path, SMALL, *PLACE, unit="micron")
    assert "the unit of its coordinates is um, not mm" in refusal(path)
    write_nifti(path, SMALL, *PLACE, code=0)
    assert "its axes are taken as x, y and z" in imported(path).remarks[0]
    data = bytearray(path.read_bytes())
    data[80:84] = bytes(4)  # pixdim[1]
    path.write_bytes(data)
    assert "it does not say how large its voxels are" in refusal(path)


def test_broken_files_are_named_as_such(tmp_path):
    write_nrrd(tmp_path / "a.nrrd", SMALL, *PLACE)
    write_nifti(tmp_path / "a.nii", SMALL, *PLACE)
    write_nifti(tmp_path / "a.nii.gz", SMALL, *PLACE)
    for path in tmp_path.glob("a.*"):
        whole = path.read_bytes()
        for part in (0, 3, 40, len(whole) // 2, len(whole) - 9):
            path.write_bytes(whole[:part])
            assert refusal(path).startswith(f'"{path.name}": '), (path.name, part)
        path.write_bytes(b"solid liver\n" * 100)
        assert "does not begin with" in refusal(path)
        path.write_bytes(whole[:-40] + bytes(40) + whole[-1:])
        with pytest.raises(MeshFileError) if path.suffix == ".nrrd" else nothing():
            imported(path)


def nothing():
    from contextlib import suppress

    return suppress(MeshFileError)


def test_voxels_beside_a_header_count_in_the_digest(tmp_path):
    write_nrrd(tmp_path / "a.nrrd", SMALL, *PLACE)
    head, data = (tmp_path / "a.nrrd").read_bytes().split(b"\n\n", 1)
    for name, encoding, content in (
        ("a.raw", b"raw", gzip.decompress(data)),
        ("a.raw.gz", b"gzip", data),
        ("a.txt", b"ascii", " ".join(map(str, SMALL.ravel())).encode()),
    ):
        text = head.replace(b"gzip", encoding) + f"\ndata file: {name}\n".encode()
        (tmp_path / "a.nhdr").write_bytes(text)
        (tmp_path / name).write_bytes(content)
        mesh = imported(tmp_path / "a.nhdr")
        assert inside_of(mesh) == pytest.approx(8.0, rel=0.02)
        (tmp_path / name).write_bytes(content + b" ")
        digest = imported(tmp_path / "a.nhdr").origin.digest
        assert digest != mesh.origin.digest


@every(
    ("module", "name", "package"),
    [
        ("nrrd", "a.nrrd", "pynrrd"),
        ("nibabel", "a.nii", "nibabel"),
        ("skimage.measure", "a.nrrd", "scikit-image"),
    ],
)
def test_a_missing_library_is_named_with_its_command(module, name, package, tmp_path):
    write_nrrd(tmp_path / "a.nrrd", SMALL, *PLACE)
    write_nifti(tmp_path / "a.nii", SMALL, *PLACE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(__import__("sys").modules, module, None)
        said = refusal(tmp_path / name)
    assert package in said and 'pip install "tissuec[images]"' in said
