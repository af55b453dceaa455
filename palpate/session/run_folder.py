"""Folders for the records and reports of runs."""

from __future__ import annotations

import datetime
from pathlib import Path

from palpate.base.errors import OutputError, PalpateError

SCENE = "scene.yaml"
"""File next to a record: the scene, with the paths of its files on the machine of the run."""


def require_writable(folder: Path) -> None:
    """Make the folder for all runs, and check that it is writable.

    Raises:
        OutputError: the folder cannot be made or written.
    """
    probe = folder / ".palpate-writable"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(
            "records cannot be written into this folder",
            where=str(folder),
            why=error.strerror or str(error),
            mend="choose another folder with --out (Session(out=...))",
        ) from None


def new_folder(out: Path, title: str) -> Path:
    """Make a folder for one run, named by title, date and time, and numbered if that name is taken.

    Raises:
        OutputError: the folder cannot be made.
    """
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    for i in range(1000):
        folder = out / (f"{title}-{stamp}" + (f"-{i + 1}" if i else ""))
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            why = error.strerror or str(error)
            raise OutputError("the run's folder cannot be made", where=str(folder), why=why, mend="use --out") from None
        return folder
    raise PalpateError("a thousand runs in one second", where=str(out), mend="wait a second")


def keep_scene(folder: Path, text: str) -> list[str]:
    """Write the scene of a run next to its record, with the paths of its files on this machine.

    The record does not contain these paths, so that equal runs give equal records on every machine. `palpate run`
    accepts the written file. Returns error messages, empty on success.
    """
    try:
        (folder / SCENE).write_text(text, encoding="utf-8")
    except OSError as error:
        return [f"no {SCENE} next to the record: {error.strerror or error}"]
    return []
