"""Opens a record of Palpate, or a ROS 2 bag of other software."""

from __future__ import annotations

from pathlib import Path

from palpate.base.errors import MissingExtraError, RecordError
from palpate.record.bags.bag import Bag
from palpate.record.bags.library import refuse_ros_1
from palpate.record.reader import Record


def _find(path: Path) -> Path:
    """Path of the record inside a folder; a folder without a record may be a bag of other software."""
    inside = path / "record.mcap"
    return inside if path.is_dir() and (inside.exists() or not _is_bag(path)) else path


def open_any(path: Path) -> Record | Bag:
    """Open a record of Palpate, or the ROS 2 bag of any CRTK session.

    Raises:
        RecordError: the file is neither of them.
    """
    found = _find(path)
    refuse_ros_1(found)
    if found.is_dir() or found.suffix == ".db3":
        return Bag.open(found)
    try:
        return Record.open(found)
    except RecordError as record_error:
        if found.suffix != ".mcap" or not found.is_file():
            raise
        try:
            return Bag.open(found)
        except (RecordError, MissingExtraError):
            raise record_error from None


def _is_bag(folder: Path) -> bool:
    return (folder / "metadata.yaml").exists() or any(folder.glob("*.mcap")) or any(folder.glob("*.db3"))
