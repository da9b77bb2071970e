"""Small files that declare much are read, or refused, within their room."""

import base64
import bz2
import gzip
import lzma
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.every import every
from tissuec.core.fields import LocatedFile
from tissuec.meshes.formats import FormatError, packed
from tissuec.meshes.formats.packed import Room, unpacked
from tissuec.meshes.generators.imported import Imported, MeshFileError

MIB = 1 << 20


def refusal(path: Path) -> str:
    with pytest.raises(MeshFileError) as caught:
        Imported(LocatedFile(path.name, path, 1e-3)).build()
    return str(caught.value)


def peak(function) -> int:
    """Return the largest memory that a call takes [bytes]."""
    tracemalloc.start()
    try:
        function()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


PACK = {
    "gzip": gzip.compress,
    "zlib": zlib.compress,
    "bzip2": bz2.compress,
    "LZMA": lzma.compress,
}


@every("method", PACK)
def test_compressed_data_unfolds_no_further_than_asked(method):
    pack = PACK[method]
    text = bytes(range(256)) * 400
    assert unpacked(pack(text), method, 1 << 30) == text
    assert unpacked(pack(text) + pack(text), method, 1 << 30) == 2 * text
    assert unpacked(pack(text) + b"\0 what follows", method, 1 << 30) == text
    assert unpacked(pack(text), method, 1000) == text[:1000]
    bomb = pack(bytes(64 * MIB))
    # Twice what is asked for, and the windows of the methods.
    assert peak(lambda: unpacked(bomb, method, 4096)) < 16 * MIB
    for broken in (pack(text)[:-20], b"", text[:100]):
        with pytest.raises(FormatError, match=r"compressed data is (truncated|damaged)"):
            unpacked(broken, method, 1 << 30)


def test_many_small_streams_unfold_in_linear_time(monkeypatch):
    """What follows a stream is not given to it again and again."""
    given = 0

    class Counting:
        def __init__(self):
            self._stream = zlib.decompressobj(zlib.MAX_WBITS | 16)

        def __getattr__(self, name):
            return getattr(self._stream, name)

        def decompress(self, piece, most):
            nonlocal given
            given += len(piece)
            return self._stream.decompress(piece, most)

    monkeypatch.setattr(packed, "_METHODS", {"gzip": Counting})
    stream = gzip.compress(np.random.default_rng(1).bytes(800))
    assert len(unpacked(2000 * stream, "gzip", 1 << 30)) == 2000 * 800
    assert given <= 2000 * (1 << 14)  # instead of 1.6 GB


HEADER = "\n".join(
    (
        "NRRD0005", "type: uint8", "dimension: 3", "space: left-posterior-superior",
        "sizes: 10 10 10", "space directions: (1,0,0) (0,1,0) (0,0,1)",
        "kinds: domain domain domain",
        "endian: little", "encoding: {encoding}", "space origin: (0,0,0)", "{more}", "", "",
    )
)  # fmt: skip
LABELS = np.pad(np.ones((6, 6, 6), np.uint8), 2).tobytes()


def written(path: Path, encoding: str, data: bytes, more: str) -> Path:
    path.write_bytes(HEADER.format(encoding=encoding, more=more).encode() + data)
    return path


@every("encoding", ("raw", "gzip", "bzip2"))
def test_lines_are_skipped_before_and_bytes_after_unpacking(encoding, tmp_path):
    pytest.importorskip("nrrd", reason="needs the images extra")
    pack = PACK.get(encoding, bytes)
    cases = (
        ("line skip: 2", b"one\ntwo\n" + pack(LABELS)),
        ("byte skip: 5", pack(b"12345" + LABELS)),
        ("byte skip: -1", pack(b"12345" + LABELS)),
        ("line skip: 1\nbyte skip: 5", b"one\n" + pack(b"12345" + LABELS)),
    )
    for more, data in cases:
        path = written(tmp_path / "a.nrrd", encoding, data, more)
        mesh = Imported(LocatedFile("a.nrrd", path, 1e-3), filling="cubes", cell=1e-3)
        assert len(mesh.build().position) == 7**3, (encoding, more)
    # As many lines as a header declares are never counted where there are fewer.
    path = written(tmp_path / "a.nrrd", encoding, pack(LABELS), "line skip: 999999999999999999")
    assert "skips 999999999999999999 lines, but there are fewer" in refusal(path)


@every("encoding", ("gzip", "bzip2"))
def test_an_image_unfolds_to_its_own_size(encoding, tmp_path):
    pytest.importorskip("nrrd", reason="needs the images extra")
    bomb = PACK[encoding](LABELS + bytes(64 * MIB))
    for more, data in (("", bomb), ("line skip: 1", b"one\n" + bomb)):
        path = written(tmp_path / "a.nrrd", encoding, data, more or "# none")
        file = LocatedFile("a.nrrd", path, 1e-3)
        read = Imported(file, filling="cubes", cell=1e-3)
        assert peak(lambda read=read: read.build()) < 32 * MIB


def grid(compressor: str, arrays: int, blocks: int, block: bytes, size: int) -> str:
    """Return a grid whose arrays all lie at the same place, in blocks of a size."""
    head = struct.pack(f"<{3 + blocks}I", blocks, size, 0, *[len(block)] * blocks)
    data = base64.b64encode(head) + base64.b64encode(blocks * block)
    cells = "".join(
        f'<DataArray type="UInt8" Name="a{k}" format="appended" offset="0"/>'
        for k in range(arrays)
    )
    return (
        '<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" '
        f'compressor="{compressor}"><UnstructuredGrid><Piece NumberOfPoints="0" '
        f'NumberOfCells="0"><Points/><Cells/><CellData>{cells}</CellData></Piece>'
        f'</UnstructuredGrid><AppendedData encoding="base64">_{data.decode()}</AppendedData>'
        "</VTKFile>"
    )


@every(
    ("compressor", "method", "arrays", "blocks"),
    [
        ("vtkZLibDataCompressor", "zlib", 1, 40),
        ("vtkLZMADataCompressor", "LZMA", 1, 40),
        ("vtkZLibDataCompressor", "zlib", 40, 1),
    ],
)
def test_arrays_of_a_grid_unfold_within_one_room(
    compressor, method, arrays, blocks, tmp_path, monkeypatch
):
    monkeypatch.setattr(Room.__init__, "__defaults__", (8 * MIB,))
    block = PACK[method](bytes(MIB))
    path = tmp_path / "a.vtu"
    path.write_text(grid(compressor, arrays, blocks, block, MIB))
    assert peak(lambda: refusal(path)) < 24 * MIB
    assert "its arrays take more than 8 MiB" in refusal(path)


def test_numbers_of_any_length_in_attributes_are_refused(tmp_path):
    path = tmp_path / "a.vtu"
    text = grid("vtkZLibDataCompressor", 1, 1, zlib.compress(b"a"), 1)
    path.write_text(text.replace('NumberOfPoints="0"', f'NumberOfPoints="{"9" * 5000}"'))
    found = refusal(path)
    assert found == f'"a.vtu": its NumberOfPoints is "{"9" * 18}", which is not a whole number'


def test_rows_without_properties_are_refused(tmp_path):
    path = tmp_path / "a.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nelement nothing 3\nelement vertex 1\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n0 0 0\n"
    )
    assert refusal(path) == '"a.ply": in its nothing elements: they have no properties'


def test_a_library_prints_nothing_besides_the_message(tmp_path, capfd):
    pytest.importorskip("nibabel", reason="needs the images extra")
    from tests.imports.images import write_nifti

    path = tmp_path / "a.nii"
    labels = np.frombuffer(LABELS, np.uint8).reshape(10, 10, 10)
    write_nifti(path, labels, np.eye(3), np.zeros(3))
    data = bytearray(path.read_bytes())
    data[108:112] = struct.pack("<f", 100.0)  # vox_offset, inside of the header
    path.write_bytes(data)
    assert "its header cannot be read" in refusal(path)
    assert capfd.readouterr() == ("", "")
