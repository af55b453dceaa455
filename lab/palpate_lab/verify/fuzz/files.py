"""Corrupted mesh files: reading must return a valid mesh or raise ``MeshError``."""

from __future__ import annotations

import struct
import tempfile
import warnings
from pathlib import Path

import numpy as np

from palpate.base.errors import MeshError
from palpate.world.mesh import Mesh
from palpate_lab.verify.fuzz import FaultError

_CUBE = [[x, y, z] for x in (0, 40) for y in (0, 40) for z in (0, 40)]
_FACES = [
    *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
    *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
]
_WORDS = (
    b"nan",
    b"-inf",
    b"1e309",
    b"99999999999",
    b"-1",
    b"solid",
    b"facet",
    b"\0",
    b"\xff\xff\xff\xff",
    b"end_header",
)


def case(seed: int) -> dict[str, int]:
    """Read one corrupted file.

    Raises:
        FaultError: the file was accepted, but its mesh is invalid.
    """
    rng = np.random.default_rng(seed)
    suffix = str(rng.choice([".stl", ".stla", ".stlb", ".ply", ".obj", ".off"]))
    written = str(rng.choice(["stl", "stla", "ply", "plyb", "obj", "off"])) if rng.uniform() < 0.3 else suffix[1:]
    data = _corrupt(rng, _file(written))
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / f"mesh{suffix}"
        path.write_bytes(data)
        try:
            mesh = Mesh.load(path)
        except MeshError:
            return {"refused": 1, suffix: 1}
    if not np.isfinite(mesh.vertices).all() or len(mesh.triangles) == 0:
        raise FaultError(f"{suffix}: the mesh is empty or not finite")
    if not np.isfinite(mesh.closest([[0.0, 0.0, 0.0]])[0]).all():
        raise FaultError(f"{suffix}: the nearest point is not finite")
    return {"loaded": 1, suffix: 1}


def _file(written: str) -> bytes:
    rows = "".join("{} {} {}\n".format(*v) for v in _CUBE)
    if written in ("stl", "stlb"):
        corners = np.array(_CUBE, dtype=float)
        facets = b"".join(struct.pack("<12fH", 0, 0, 0, *corners[row].ravel(), 0) for row in _FACES)
        return b"\0" * 80 + struct.pack("<I", len(_FACES)) + facets
    if written == "stla":
        loops = ("".join("vertex {} {} {}\n".format(*_CUBE[i]) for i in row) for row in _FACES)
        facets_text = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
        return f"solid cube\n{facets_text}endsolid\n".encode()
    if written == "obj":
        lines = "".join(f"v {row}\n" for row in rows.splitlines())
        return (lines + "".join("f {} {} {}\n".format(*(i + 1 for i in row)) for row in _FACES)).encode()
    faces = "".join("3 {} {} {}\n".format(*row) for row in _FACES)
    if written == "off":
        return f"OFF\n8 12 0\n{rows}{faces}".encode()
    head = "ply\nformat {} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
    if written == "ply":
        return (head.format("ascii") + rows + faces).encode()
    packed = b"".join(struct.pack("<3f", *v) for v in _CUBE) + b"".join(struct.pack("<B3i", 3, *f) for f in _FACES)
    return head.format("binary_little_endian").encode() + packed


def _corrupt(rng: np.random.Generator, data: bytes) -> bytes:
    """Truncate, overwrite or duplicate parts of the data, or insert critical keywords."""
    for _ in range(int(rng.integers(0, 4))):
        at = int(rng.integers(0, len(data) + 1))
        kind = rng.integers(0, 5)
        if kind == 0:
            data = data[:at]
        elif kind == 1:
            data = data[:at] + rng.bytes(int(rng.integers(1, 9))) + data[at + 8 :]
        elif kind == 2:
            word = _WORDS[rng.integers(len(_WORDS))]
            data = data[:at] + word + data[at + int(rng.integers(0, len(word) + 1)) :]
        elif kind == 3:
            data = data[:at] + data[: int(rng.integers(0, 300))] + data[at:]
        else:  # a false triangle count
            count = struct.pack("<I", int(rng.choice([0, 1, 13, 2**24, 2**31 - 1, 2**32 - 1])))
            data = data[:80] + count + data[84:]
    return data
