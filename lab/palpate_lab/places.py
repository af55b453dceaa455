"""Where the laboratory finds the clone that it runs from, and recordings that are no part of it."""

from __future__ import annotations

import os
from pathlib import Path


def repository() -> Path | None:
    """The clone of the repository; None where Palpate was installed from a wheel."""
    folder = Path(__file__).resolve().parents[2]
    return folder if (folder / "CMakeLists.txt").is_file() else None


def data() -> Path:
    """Folder of meshes and recordings: PALPATE_DATA, or shared/data beside the repository. It need not exist."""
    return Path(os.environ.get("PALPATE_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
