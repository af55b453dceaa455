"""The index of a large mesh, kept in the user's cache, and found there by the content of its file.

It is used where it lies: the file of the cache is mapped into memory, and copied nowhere.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base import cache

CACHED_FROM = 300_000
"""Triangles from which the index is cached: indexing takes over 0.2 s there, and reading a fraction of it."""
CACHED_SIZE = 10_000_000
"""Size from which a file is found in the cache by its content, so that it is not parsed again [bytes]."""
KEPT = 4
"""Number of smaller meshes that this process keeps, since programs build the same scene many times."""
KEPT_TO = 100_000
"""Triangles up to which a mesh is kept."""
_WHOLE = (".stl", ".stla", ".stlb", ".ply", ".off")  # formats without a second file


Soup = tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]
"""Vertices (n, 3) [m] and triangles (m, 3)."""


def build(soup: list[Soup]) -> tuple[_core.Mesh, str]:
    """The core mesh of the vertices and triangles in a list, and its key in the cache; empty for a small mesh.

    A large mesh that the cache holds is read from there, and the last small meshes are at hand. The arrays are taken
    out of the list: those of a large mesh are freed before it is built, unless somebody else holds them.

    Raises:
        ValueError: the arrays are no mesh.
    """
    vertices, triangles = soup.pop()
    if len(triangles) < CACHED_FROM:
        return _small(vertices, triangles), ""
    key = cache.source_key(_libraries(), *(hashlib.sha256(a.data).hexdigest() for a in (vertices, triangles)))
    found = load(key)
    if found is None:
        welded = _core.Welded(vertices, triangles)
        del vertices, triangles
        found = welded.mesh()
        cache.keep_bytes("mesh_index", key, found.image_pieces())
    return found, key


_recent: dict[tuple[bytes, bytes], _core.Mesh] = {}  # by the digests of vertices and triangles, the oldest first


def _small(vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.int32]) -> _core.Mesh:
    """The core mesh of a small mesh; core meshes never change, so scenes may share them."""
    if len(triangles) > KEPT_TO:
        return _core.Mesh(vertices, triangles)
    key = (hashlib.blake2b(vertices.data).digest(), hashlib.blake2b(triangles.data).digest())
    mesh = _recent.pop(key, None) or _core.Mesh(vertices, triangles)
    _recent[key] = mesh
    for oldest in list(_recent)[:-KEPT]:
        _recent.pop(oldest, None)
    return mesh


def load(key: str) -> _core.Mesh | None:
    """The mesh of a key; None if the cache does not hold it."""
    image = cache.load_bytes("mesh_index", key)
    with suppress(ValueError):  # a file of the right name with other contents: built anew
        return None if image is None else _core.Mesh.from_image(image)
    return None


def file_key(path: Path, *choices: object) -> str:
    """Key of the content of a large file and what is chosen of it; empty for a file that is read each time."""
    with suppress(OSError):  # reading the file then says why
        if path.suffix.lower() in _WHOLE and path.stat().st_size >= CACHED_SIZE:
            with path.open("rb") as file:
                content = hashlib.file_digest(file, "sha256").hexdigest()
            return cache.source_key([*_libraries(), *_readers()], content, *choices)
    return ""


def load_file(key: str) -> tuple[_core.Mesh, str, str] | None:
    """The mesh of a file by `file_key`, with its key and its unit; None if the cache does not hold it."""
    known = cache.load("mesh_file", key) if key else None
    mesh = None if known is None else load(str(known.get("key", "")))
    return None if known is None or mesh is None else (mesh, str(known["key"]), str(known["unit"]))


def keep_file(file: str, key: str, unit: str) -> None:
    """Keep which mesh a file holds, by `file_key` and the mesh's key, unless one of them is empty."""
    if file and key:
        cache.keep("mesh_file", file, {"key": np.array(key), "unit": np.array(unit)})


def _readers() -> list[Path]:
    """The source files that read meshes."""
    return sorted(Path(__file__).parent.glob("*.py"))


def _libraries() -> list[Path]:
    """The compiled files that make the index: another build of them has another layout."""
    folder = Path(str(_core.__file__)).parent
    return sorted(folder.glob("libpalpate.*")) or [Path(str(_core.__file__))]
