"""Limits that hold before a file is loaded: a small file of a stranger must not take the machine.

Readers call these functions in place of ``Path.read_bytes``, ``numpy.load``, ``gzip.decompress`` and their kin. A limit
that is exceeded raises `LimitError`, which is an ``OSError`` and a ``ValueError``: each reader already turns these into
an error of its own, with the name of the file. `docs/security.md` lists the limits.
"""

from __future__ import annotations

import bz2
import io
import json
import os
import stat
import struct
import threading
import zipfile
import zlib
from collections.abc import Callable
from math import prod
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

MEBI = 1 << 20
MOST_UNPACKED = 384 * MEBI
"""Largest size that packed or sparse data may unfold to [bytes]: a CT of 512 x 512 x 750 voxels of two bytes."""
MOST_TEXT = 16 * MEBI
"""Largest file of text that people write: YAML, JSON, URDF [bytes]."""
MOST_TABLE = 256 * MEBI
"""Largest file of text that programs write: a CSV [bytes]."""
MOST_FILE = 4096 * MEBI
"""Largest file that is read at all [bytes]; it must really fill the disk."""
_BLOCK = MEBI
_ARRAYS = 64  # arrays in one archive
_UNPACKERS = threading.local()  # what unpacks zstd, once a thread


class LimitError(OSError, ValueError):
    """A file is larger, or unfolds to more, than any file of its kind; or it is not a file, but a device or a pipe."""


def require_file(path: str | os.PathLike[str], most: int = MOST_FILE) -> int:
    """Size of a regular file [bytes]; symbolic links are followed.

    Raises:
        LimitError: it is a device, a pipe or a socket, it is larger than `most` bytes, or a large part is a hole.
        OSError: it is missing, or a folder.
    """
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(21, "it is a folder", str(path))
    if not stat.S_ISREG(found.st_mode):
        kinds = ((stat.S_ISFIFO, "a pipe"), (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"))
        kind = next((name for test, name in kinds if test(found.st_mode)), "a socket")
        raise LimitError(f"it is {kind}, not a file")
    if found.st_size > most:
        raise LimitError(f"it has {found.st_size:,} bytes; at most {most:,} are read")
    if found.st_size > MOST_UNPACKED // 4 and 8 * 512 * found.st_blocks < found.st_size:
        raise LimitError(f"it has {found.st_size:,} bytes, of which {512 * found.st_blocks:,} are on the disk")
    return found.st_size


def read_bytes(path: str | os.PathLike[str], most: int = MOST_FILE) -> bytes:
    """Bytes of a regular file. Errors as in `require_file`."""
    require_file(path, most)
    with open(path, "rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise LimitError(f"it has more than {most:,} bytes, and grows while it is read")
    return data


def read_text(path: str | os.PathLike[str], most: int = MOST_TEXT, encoding: str = "utf-8") -> str:
    """Text of a regular file, with its line ends as ``\\n``. Errors as in `require_file`; UnicodeDecodeError."""
    text = read_bytes(path, most).decode(encoding)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def require_unpacked(size: int, most: int = MOST_UNPACKED) -> None:
    """Refuse a size of unpacked data [bytes] that a header announces.

    Raises:
        LimitError: it is negative, or larger than `most`.
    """
    if not 0 <= size <= most:
        raise LimitError(f"it announces {size:,} bytes; at most {most:,} are unpacked")


def require_present(count: int, size: int, present: int, what: str) -> None:
    """Refuse a number of items that a header announces and the file cannot hold.

    Args:
        count: announced number of items.
        size: fewest bytes of an item.
        present: bytes that are left in the file.
        what: name of the items for the message.

    Raises:
        LimitError: the items do not fit, or their number is negative.
    """
    if not 0 <= count * size <= present:
        raise LimitError(f"its header announces {count:,} {what}, and {present:,} bytes are there")


def gunzip(data: bytes, most: int = MOST_UNPACKED) -> bytes:
    """Unpacked gzip or zlib data, all members.

    Raises:
        LimitError: it unfolds to more than `most` bytes. zlib.error, EOFError: the data are damaged or cut short.
    """
    return _members(data, most, lambda: zlib.decompressobj(zlib.MAX_WBITS | 32))


def bunzip2(data: bytes, most: int = MOST_UNPACKED) -> bytes:
    """Unpacked bzip2 data, all members. Errors as in `gunzip`; OSError of damaged data."""
    return _members(data, most, bz2.BZ2Decompressor)


def _members(data: bytes, most: int, make: Callable[[], Any]) -> bytes:
    """All members of packed data, each unpacked by a new object of `make`; zeros between members are padding."""
    parts, left = [], most
    while data:
        unpack = make()
        part = unpack.decompress(data, left + 1)
        if len(part) > left:
            raise LimitError(f"it unfolds to more than {most:,} bytes")
        if not unpack.eof:
            raise EOFError("the packed data end too early")
        parts.append(part)
        left -= len(part)
        data = unpack.unused_data.lstrip(b"\0")
    return parts[0] if len(parts) == 1 else b"".join(parts)


def gunzip_head(path: str | os.PathLike[str], size: int) -> bytes:
    """At most `size` first bytes of a gzip file. Errors as in `require_file`; zlib.error."""
    require_file(path)
    with open(path, "rb") as file:
        return zlib.decompressobj(zlib.MAX_WBITS | 32).decompress(file.read(_BLOCK), size)


def unzstd(data: bytes, size: int | None = None, most: int = MOST_UNPACKED) -> bytes:
    """Unpacked zstd data.

    Args:
        data: the packed bytes.
        size: number of bytes that the file announces, where it does.
        most: largest number of bytes.

    Raises:
        LimitError: the size is above `most`, or the data unfold to another one. zstandard.ZstdError: damaged data.
    """
    import zstandard

    require_unpacked(size or 0, most)
    if size is not None and zstandard.frame_content_size(data) == size:
        if not hasattr(_UNPACKERS, "zstd"):
            _UNPACKERS.zstd = zstandard.ZstdDecompressor(max_window_size=1 << 27)
        return bytes(_UNPACKERS.zstd.decompress(data))  # no more than the frame announces
    stream = zstd_stream(io.BytesIO(data), most if size is None else size)
    with stream:
        out = stream.read()
    if size is not None and len(out) != size:
        raise LimitError(f"it announces {size:,} bytes, and unfolds to {len(out):,}")
    return out


def zstd_stream(file: BinaryIO, most: int = MOST_UNPACKED) -> BinaryIO:
    """A stream of unpacked zstd data; LimitError when it unfolds to more than `most` bytes."""
    import zstandard

    unpack = zstandard.ZstdDecompressor(max_window_size=1 << 27)
    return io.BufferedReader(_Bounded(unpack.stream_reader(file, read_across_frames=True), most))  # type: ignore[return-value, unused-ignore]


class _Bounded(io.RawIOBase):
    """A stream that ends with LimitError after a number of bytes."""

    def __init__(self, stream: Any, most: int) -> None:
        self._stream, self._left, self._most = stream, most, most

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        data = self._stream.read(len(buffer))
        self._left -= len(data)
        if self._left < 0:
            raise LimitError(f"it unfolds to more than {self._most:,} bytes")
        buffer[: len(data)] = data
        return len(data)


def unpack(data: bytes, kind: str, size: int, most: int = MOST_UNPACKED) -> bytes:
    """A chunk of an MCAP file: `kind` is empty, zstd or lz4. Errors as in `unzstd`; RuntimeError of damaged lz4."""
    require_unpacked(size, most)
    if kind == "zstd":
        return unzstd(data, size, most)
    if kind == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped, unused-ignore]

        data = LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    elif kind:
        raise ValueError(f"compression {kind!r}; zstd and lz4 are read")
    if len(data) != size:
        raise LimitError(f"it announces {size:,} bytes, and unfolds to {len(data):,} or more")
    return data


def load_npy(data: bytes | BinaryIO, present: int | None = None) -> npt.NDArray[Any]:
    """The array of an ``.npy`` file, never an object.

    Args:
        data: its bytes, or a stream.
        present: number of bytes in the stream.

    Raises:
        LimitError: its header announces more than is there. ValueError: it is damaged, or holds objects.
    """
    stream = io.BytesIO(data) if isinstance(data, bytes) else data
    have = len(data) if isinstance(data, bytes) else present or 0
    version = np.lib.format.read_magic(stream)  # type: ignore[no-untyped-call, unused-ignore]
    if version > (2, 0):
        raise ValueError(f"version {version[0]}.{version[1]} of the format; 1.0 and 2.0 are read")
    width = 2 if version == (1, 0) else 4
    length = stream.read(width)
    (announced,) = struct.unpack("<H" if width == 2 else "<I", length)
    if announced > 65_536:
        raise LimitError(f"its header announces {announced:,} bytes of description")
    again = io.BytesIO(length + stream.read(announced))
    read = np.lib.format.read_array_header_1_0 if width == 2 else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = read(again)  # type: ignore[no-untyped-call, unused-ignore]
    if dtype.hasobject:
        raise ValueError("it holds objects of Python; numbers and texts are read")
    require_present(prod(shape), max(dtype.itemsize, 1), have, "values")
    flat = np.frombuffer(stream.read(prod(shape) * dtype.itemsize), dtype) if dtype.itemsize else np.zeros(0, dtype)
    return flat.reshape(shape[::-1]).T.copy() if fortran else flat.reshape(shape).copy()


def load_npz(source: bytes | str | os.PathLike[str], most: int = MOST_UNPACKED) -> dict[str, npt.NDArray[Any]]:
    """The arrays of an ``.npz`` file, by name.

    Raises:
        LimitError: it unfolds to more than `most` bytes, or an array announces more than is there.
        OSError, ValueError, zipfile.BadZipFile, zlib.error, EOFError: it cannot be read, or is damaged.
    """
    data = source if isinstance(source, bytes) else read_bytes(source)
    arrays: dict[str, npt.NDArray[Any]] = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        infos = archive.infolist()
        require_archive(archive, most)
        for info in infos[:_ARRAYS]:
            if info.filename.endswith(".npy"):
                with archive.open(info) as stream:
                    unpacked = stream.read(info.file_size + 1)
                arrays[info.filename.removesuffix(".npy")] = load_npy(unpacked)
    return arrays


def require_archive(archive: zipfile.ZipFile, most: int = MOST_UNPACKED) -> None:
    """Refuse a zip archive that unfolds to more than `most` bytes. Raises LimitError."""
    require_unpacked(sum(info.file_size for info in archive.infolist()), most)


def require_nesting(text: str, most: int = 500) -> None:
    """Refuse text whose brackets open deeper than `most`, before a parser that recurses reads it. Raises LimitError."""
    if text.count("[") + text.count("{") <= most:
        return
    depth, quoted, skip = 0, False, False
    for letter in text:
        if skip:
            skip = False
        elif letter == "\\":
            skip = quoted
        elif letter == '"':
            quoted = not quoted
        elif not quoted and letter in "[{":
            depth += 1
            if depth > most:
                raise LimitError(f"its brackets open {most:,} deep")
        elif not quoted and letter in "]}":
            depth -= 1


def load_json(text: str) -> Any:
    """Values of JSON text.

    Raises:
        LimitError: its brackets open too deep. ValueError: it is no JSON.
    """
    require_nesting(text)
    return json.loads(text)
