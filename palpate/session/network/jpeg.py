"""Packs pictures as JPEG."""

from __future__ import annotations

import io
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from palpate.base.errors import MissingExtraError

QUALITY = 80
"""Quality of the pictures (1 to 95)."""


def packed(picture: NDArray[np.uint8]) -> bytes:
    """A picture (h, w, 3) as JPEG."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(out, "JPEG", quality=QUALITY)
    return out.getvalue()


def require_packer() -> None:
    """Check that `packed` works.

    Raises:
        MissingExtraError: it does not.
    """
    if find_spec("PIL") is None:  # it comes with viser and matplotlib
        raise MissingExtraError("what packs pictures as JPEG", "viewer")
