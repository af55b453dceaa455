"""Where a run keeps its record and report."""

from __future__ import annotations

import datetime
from pathlib import Path

from palpate.errors import OutputError, PalpateError

SCENE = "scene.yaml"
"""Beside a record: its scene, with the mesh files as found on the machine of the run."""


def require_writable(folder: Path) -> None:
    """Make the folder of all runs and try it, before anything runs.

    Raises:
        OutputError: it cannot be made or written.
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
    """A folder for one run: title, date and time, numbered when there is one already.

    Raises:
        OutputError: it cannot be made.
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
    """Write a run's scene, with its mesh files as found on this machine, beside its record.

    The record itself does not say where the meshes lie: the same run gives the same record everywhere. This file does,
    and `palpate run` takes it. Returns what went wrong, in words.
    """
    try:
        (folder / SCENE).write_text(text, encoding="utf-8")
    except OSError as error:
        return [f"no {SCENE} beside the record: {error.strerror or error}"]
    return []
