"""The index of a large mesh, kept in the user's cache."""

from __future__ import annotations

from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate import _core, cache

CACHED_FROM = 300_000
"""Triangles from which the index is cached: indexing takes over 0.2 s there, and reading a fraction of it."""


def build(vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.int32]) -> _core.Mesh:
    """The core mesh of vertices (n, 3) [m] and triangles (m, 3), read from the cache if it is large and known.

    Raises:
        ValueError: the arrays are no mesh.
    """
    if len(triangles) < CACHED_FROM:
        return _core.Mesh(vertices, triangles)
    built: list[_core.Mesh] = []

    def image() -> cache.Arrays:
        built.append(_core.Mesh(vertices, triangles))
        return {"image": built[0].image()}

    key = cache.source_key(_libraries(), *(sha256(a.data).hexdigest() for a in (vertices, triangles)))
    found = cache.load_or_make("mesh_index", key, image)
    with suppress(ValueError, KeyError):  # a file of the right name with other contents: built anew
        return built[0] if built else _core.Mesh.from_image(found["image"])
    return _core.Mesh(vertices, triangles)


def _libraries() -> list[Path]:
    """The compiled files that make the index: another build of them has another layout."""
    folder = Path(str(_core.__file__)).parent
    return sorted(folder.glob("libpalpate.*")) or [Path(str(_core.__file__))]
