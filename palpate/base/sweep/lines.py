"""An append-only file of JSON values, one a line, each with its CRC-32; one process writes it at a time.

A line that a kill or a full disk has cut off is removed when the file is opened again.
"""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from typing import Any
from zlib import crc32

from palpate.base import limits
from palpate.base.errors import OutputError, SweepError


class Lines:
    """The file; `entries` are the values that it held when it was opened, None for a broken line.

    Args:
        path: created if missing, otherwise continued.

    Raises:
        SweepError: another process writes the file. OutputError: it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if path.exists():
                limits.require_file(path)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise _refusal(path, error) from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            data = limits.read_bytes(path)
        except BlockingIOError:
            os.close(self._file)
            why = "another process is writing it"
            raise SweepError("the journal is in use", where=str(path), why=why, mend="wait for its end") from None
        except BaseException:
            os.close(self._file)
            raise
        self._whole = data.rfind(b"\n") + 1
        self.empty = not data
        self.entries: list[Any] = [_read(line) for line in data[: self._whole].splitlines()]

    def take_up(self) -> None:
        """Remove an incomplete last line; the next values follow the complete ones."""
        os.ftruncate(self._file, self._whole)
        os.lseek(self._file, 0, os.SEEK_END)

    def append(self, entries: list[Any]) -> None:
        """Append values.

        Raises:
            OutputError: the file cannot be written.
        """
        texts = [json.dumps(entry, separators=(",", ":")).encode() for entry in entries]
        lines = b"".join(b"%08x %s\n" % (crc32(text), text) for text in texts)
        try:
            while lines:
                lines = lines[os.write(self._file, lines) :]
        except OSError as error:
            raise _refusal(self.path, error) from None

    def sync(self) -> None:
        """Return when the values are on the disk.

        Raises:
            OutputError: the disk does not take them.
        """
        try:
            os.fsync(self._file)
        except OSError as error:
            raise _refusal(self.path, error) from None

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


def read_lines(path: Path) -> list[Any]:
    """The complete values of such a file, None for a broken line; also while another process writes it.

    Raises:
        OSError: the file cannot be read.
    """
    data = limits.read_bytes(path)
    return [_read(line) for line in data[: data.rfind(b"\n") + 1].splitlines()]


def _read(line: bytes) -> Any:
    crc, _, text = line.partition(b" ")
    return json.loads(text) if b"%08x" % crc32(text) == crc else None


def _refusal(path: Path, error: OSError) -> OutputError:
    return OutputError("the journal cannot be written", where=str(path), why=error.strerror or str(error))
