"""Reader of PCD files, the point clouds of PCL: ascii, binary, and binary_compressed (LZF)."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from palpate.arrays import Array
from palpate.errors import RegistrationError


def read_pcd(path: Path) -> Array:
    """Points (N, 3) [m] with finite coordinates.

    Raises:
        RegistrationError: the file cannot be read, is damaged, or has no x, y, z.
    """
    try:
        data = path.read_bytes()
        head, body = _header(data)
        dtype = np.dtype([
            (name, f"<{ {'F': 'f', 'I': 'i', 'U': 'u'}[kind] }{size}", (int(count),))
            for name, kind, size, count in zip(head["FIELDS"], head["TYPE"], head["SIZE"], head["COUNT"], strict=True)
        ])  # fmt: skip
        n = int(head["POINTS"][0])
        table = _decoded(head["DATA"][0], body, dtype, n)
        points = np.stack([table[axis][:, 0] for axis in "xyz"], axis=1).astype(np.float64)
    except (OSError, KeyError, ValueError, IndexError, struct.error) as error:
        raise RegistrationError("the file is not a readable PCD", where=str(path), why=str(error)) from None
    return np.asarray(points[np.isfinite(points).all(axis=1)])


def _header(data: bytes) -> tuple[dict[str, list[str]], bytes]:
    head: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in head:
        end = data.index(b"\n", at)
        key, *values = data[at:end].decode("ascii").split() or [""]
        head[key] = values
        at = end + 1
    head.setdefault("COUNT", ["1"] * len(head["FIELDS"]))
    return head, data[at:]


def _decoded(kind: str, body: bytes, dtype: np.dtype[np.void], n: int) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    table = np.zeros(n, dtype)
    if kind == "ascii":
        values = np.array(body.split(), dtype=np.float64).reshape(n, -1)
        at = 0
        for name in dtype.names or ():
            width = dtype[name].shape[0]
            table[name] = values[:, at : at + width]
            at += width
    elif kind == "binary":
        table[:] = np.frombuffer(body, dtype, n)
    else:
        packed, size = struct.unpack("<II", body[:8])
        flat, at = lzf(body[8 : 8 + packed], size), 0
        for name in dtype.names or ():  # stored field by field
            part = dtype[name]
            table[name] = np.frombuffer(flat, part.base, n * part.shape[0], at).reshape(n, -1)
            at += n * part.itemsize
    return table


def lzf(data: bytes, size: int) -> bytes:
    """Decompress LZF (Lehmann's liblzf): literal runs and back references.

    Raises:
        ValueError: the data are damaged.
    """
    out, at = bytearray(), 0
    while at < len(data):
        control = data[at]
        at += 1
        if control < 32:
            out += data[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[at]
            at += 1
        back = len(out) - ((control & 31) << 8) - data[at] - 1
        at += 1
        if back < 0:
            raise ValueError("a back reference before the start")
        while length + 2 > 0:
            piece = out[back : back + length + 2]
            out += piece
            length, back = length - len(piece), back + len(piece)
    if len(out) != size:
        raise ValueError(f"{len(out)} bytes instead of {size}")
    return bytes(out)
