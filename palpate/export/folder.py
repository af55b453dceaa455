"""A folder that appears whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from palpate.base.errors import OutputError


@contextmanager
def whole_folder(out: Path) -> Iterator[Path]:
    """A draft beside a folder, renamed to the folder at the end, and removed after any exception; an absolute path,
    since a library may join a relative one to itself.

    Raises:
        OutputError: the folder exists already and holds something, or it cannot be written.
    """
    require_free(out)
    draft = out.absolute().parent / f".{out.name}.part-{os.getpid()}"
    try:
        draft.mkdir(parents=True)
        yield draft
        draft.rename(out)
    except OSError as error:
        why = f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error)
        mend = "free some space, or choose another place; nothing was left behind"
        raise OutputError("the data set cannot be written", where=str(out), why=why, mend=mend) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def require_free(out: Path) -> None:
    """Check that a folder does not exist, or is empty.

    Raises:
        OutputError: it holds something, or it is a file.
    """
    if out.is_dir() and not any(out.iterdir()):
        return
    if out.exists():
        what = "the folder exists already and is not empty" if out.is_dir() else "there is a file of this name"
        raise OutputError(what, where=str(out), mend="give another name with --out, or remove it")
