"""Sizes that the headers of mesh files announce, compared with the files before a library believes them."""

from __future__ import annotations

import math
import re
import struct
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

from palpate.base import limits
from palpate.base.limits import LimitError

_PLY_SIZES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("double", "float64"), 8),
}
_LEGACY = re.compile(
    rb"^\s*(POINTS|POLYGONS|CELLS|CELL_TYPES|LINES|VERTICES|TRIANGLE_STRIPS|POINT_DATA|CELL_DATA|[XYZ]_COORDINATES)"
    rb"\s+(\d+)(?:\s+(\d+))?",
    re.MULTILINE,
)
_DIMENSIONS = re.compile(rb"^\s*DIMENSIONS\s+(\d+)\s+(\d+)\s+(\d+)", re.MULTILINE)
_XML = re.compile(rb'(?:NumberOf(?:Points|Cells|Polys|Verts|Lines|Strips|Tuples)|Extent)\s*=\s*"([^"]*)"')
_GMSH = re.compile(rb"^\$(Nodes|Elements|PhysicalNames|Periodic|Entities)\s+(\d+)", re.MULTILINE)
_GMSH_BLOCKS = re.compile(rb"^\$(Nodes|Elements)\r?\n(.{32})", re.MULTILINE | re.DOTALL)
_MEDIT = re.compile(
    rb"^\s*(Vertices|Triangles|Tetrahedra|Hexahedra|Edges|Corners|Quadrilaterals)\s+(\d+)", re.MULTILINE
)
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_WIDTHS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}


def require(path: Path, data: bytes) -> None:
    """Refuse a mesh file whose header announces more than it holds.

    Args:
        path: the file, whose ending decides.
        data: its bytes.

    Raises:
        LimitError: a size does not fit. ValueError, KeyError, TypeError: the header is damaged.
    """
    check = _CHECKS.get(path.suffix.lower())
    if check is not None:
        check(data)


def _ply(data: bytes) -> None:
    end = data.find(b"end_header")
    if end < 0:
        return
    need, count, width, binary = 0, 0, 0, False
    for line in [*data[:end].decode("latin-1").splitlines(), "element end 0"]:
        words = line.split()
        if words[:1] == ["format"]:
            binary = "ascii" not in words
        elif words[:1] == ["element"]:
            need, count, width = need + count * max(width, 1), int(words[2]), 0
        elif words[:1] == ["property"]:
            size = 1 if words[1] == "list" else _PLY_SIZES.get(words[1], 4)
            width += size if binary else 2
    limits.require_present(need, 1, len(data) - end, "bytes of vertices and faces")


def _off(data: bytes) -> None:
    words = re.sub(rb"#[^\n]*", b"", data[:4096]).split()
    counts = [int(word) for word in words[:4] if word.isdigit()][:2]
    limits.require_present(sum(counts), 2, len(data), "vertices and faces")


def _legacy_vtk(data: bytes) -> None:
    for name, count, more in _LEGACY.findall(data):
        limits.require_present(max(int(count), int(more or 0)), 1, len(data), name.decode().lower())
    for sizes in _DIMENSIONS.findall(data):
        limits.require_present(math.prod(map(int, sizes)), 1, len(data), "points of a grid")


def _xml_vtk(data: bytes) -> None:
    packed = b"compressor" in data
    for text in _XML.findall(data):
        numbers = [abs(int(word)) for word in text.split() if word.lstrip(b"-").isdigit()]
        count = math.prod(number + 1 for number in numbers[1::2]) if len(numbers) == 6 else max(numbers, default=0)
        if packed:
            limits.require_unpacked(4 * count)
        else:
            limits.require_present(count, 1, len(data), "points or cells")


def _gmsh(data: bytes) -> None:
    for name, count in _GMSH.findall(data):
        limits.require_present(int(count), 1, len(data), name.decode().lower())
    if re.match(rb"\$MeshFormat\s+4\S*\s+1\s", data):
        for name, head in _GMSH_BLOCKS.findall(data):
            blocks, count, *_ = struct.unpack("<4Q", head)
            limits.require_present(max(blocks, count), 1, len(data), name.decode().lower())


def _medit(data: bytes) -> None:
    for name, count in _MEDIT.findall(data):
        limits.require_present(int(count), 2, len(data), name.decode().lower())


def _glb(data: bytes) -> None:
    length = struct.unpack_from("<I", data, 12)[0]
    limits.require_present(length, 1, len(data) - 20, "bytes of JSON")
    _gltf_tree(limits.load_json(data[20 : 20 + length].decode()))


def _gltf(data: bytes) -> None:
    _gltf_tree(limits.load_json(data.decode()))


def _gltf_tree(tree: Any) -> None:
    """Values fit into their views, and the nodes are a tree: a node below two others would be drawn many times."""
    views, total = tree.get("bufferViews", []), 0
    for one in tree.get("accessors", []):
        size = int(one["count"]) * _COMPONENTS[one["type"]] * _WIDTHS[one["componentType"]]
        total += size
        if "bufferView" in one:
            limits.require_present(size, 1, int(views[one["bufferView"]]["byteLength"]), "bytes of an accessor")
    limits.require_unpacked(total)
    children = [child for node in tree.get("nodes", []) for child in node.get("children", [])]
    roots = {node for scene in tree.get("scenes", []) for node in scene.get("nodes", [])}
    if len(set(children)) < len(children) or roots & set(children):
        raise LimitError("a node has more than one parent")


def _archive(data: bytes) -> None:
    with zipfile.ZipFile(BytesIO(data)) as archive:
        limits.require_archive(archive)


_CHECKS = {
    ".ply": _ply,
    ".off": _off,
    ".vtk": _legacy_vtk,
    ".vtp": _xml_vtk,
    ".vtu": _xml_vtk,
    ".msh": _gmsh,
    ".mesh": _medit,
    ".glb": _glb,
    ".gltf": _gltf,
    ".3mf": _archive,
}


class Beside:
    """Files that a mesh file names, such as buffers and textures: regular files in its folder, for trimesh.

    Args:
        folder: folder of the mesh file.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, name: str) -> bytes:
        """Bytes of a file. Errors as in `palpate.base.limits.read_bytes`."""
        return limits.read_bytes(self._folder / name.strip(), limits.MOST_UNPACKED)

    def __getitem__(self, name: str) -> bytes:
        """As `get`."""
        return self.get(name)

    def __contains__(self, name: str) -> bool:
        """True if there is such a file."""
        return (self._folder / name.strip()).is_file()

    def keys(self) -> list[str]:
        """No names: files are asked for by name."""
        return []

    def namespaced(self, namespace: str) -> Beside:
        """The files of a folder below."""
        return Beside(self._folder / namespace)


def load_by_trimesh(path: Path, data: bytes | None = None) -> Any:
    """A mesh as trimesh reads it, unprocessed, after its header was compared with it.

    Raises:
        Exception: trimesh raises many types; LimitError as in `require`.
    """
    import trimesh

    data = limits.read_bytes(path) if data is None else data
    require(path, data)
    kind = path.suffix.lower().removeprefix(".")
    return trimesh.load(BytesIO(data), file_type=kind, resolver=Beside(path.parent), force="mesh", process=False)  # type: ignore[arg-type]
