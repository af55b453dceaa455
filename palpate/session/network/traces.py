"""Measured delays of a network as a trace of the emulator: from a table, or from captured packets."""

from __future__ import annotations

import csv
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.arrays.checks import is_number
from palpate.base.errors import PalpateError

Trace = list[tuple[float, float]]
"""(time, delay) [s]; a negative delay is a loss."""

_MAGIC = {0xA1B2C3D4: 1e-6, 0xA1B23C4D: 1e-9}
"""Resolution of the time stamps of a pcap file by its first word [s]."""
_LONG = 5.0  # median delay that is none of a network [s]
_LEAST = 10
_SPARSE = 100  # most periods a packet: more of them are no stream
_WINDOW = 200  # packets before and after one that tell how early it could have come
_EARLIEST = 0.02  # share of them that count as none: packets with a wrong number
_FAR = 0.1  # share by which the period may differ from the median distance of two packets
_MANY, _UNSURE, _BEGINNINGS = 2000, 0.03, 31  # packets of the first fits, and the periods with which they begin
_FITS = 3  # of a line to the same part


def read_trace(path: str | Path) -> Trace:
    """The trace of a file.

    A table (.csv, with commas, semicolons or tabs) has the columns time and delay [s], of more than two those of these
    names; an empty or negative delay is a loss. Lines with # are left out. A capture (.pcap) holds the packets of one
    stream with a constant period, as they arrived: the delay of each is how much later it came than the earliest line
    of that period allows, and gaps are losses. The smallest delay cannot be seen at one end, and is 0.

    Raises:
        PalpateError: the file does not exist, is no such file, or holds too few packets.
    """
    path = Path(path)
    try:
        limits.require_file(path)
        trace = _of_table(path) if path.suffix == ".csv" else _of_arrivals(path, _arrivals(path))
    except FileNotFoundError:
        raise PalpateError(f"{path}: there is no such file", mend="give a trace: FILE.csv or FILE.pcap") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise PalpateError(
            f"{path}: the trace cannot be read", why=str(error)[:200], mend="give FILE.csv or FILE.pcap"
        ) from None
    arrived = sum(delay >= 0.0 for _, delay in trace)
    if len(trace) < 2 or arrived == 0:
        raise PalpateError(f"{path}: {arrived} usable packets", mend="record at least a few seconds")
    return trace


def _of_table(path: Path) -> Trace:
    lines = limits.read_text(path, limits.MOST_TABLE).removeprefix("\ufeff").splitlines()
    used = [k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    mark = max(",;\t", key=lines[used[0]].count) if used else ","
    rows = list(csv.reader((lines[k] for k in used), delimiter=mark))
    if len(rows) != len(used):
        raise csv.Error("a quote is not closed")
    columns = (0, 1)
    if rows and not is_number(rows[0][0]):
        columns = _columns(path, rows.pop(0))
        used.pop(0)
    out: Trace = []
    for number, row in zip(used, rows, strict=True):
        try:
            delay = row[columns[1]].strip() if len(row) > columns[1] else ""
            out.append((float(row[columns[0]]), float(delay) if delay else -1.0))
        except (ValueError, IndexError):
            what = f"{path}, line {number + 1}: {mark.join(row)[:60]!r} is no time and delay"
            raise PalpateError(what, mend="write seconds, e.g. 0.25,0.041") from None
    table = np.array(out).reshape(-1, 2)
    if not np.isfinite(table).all():
        raise PalpateError(f"{path}: times and delays must be finite", mend="leave the delay of a lost packet empty")
    if (np.diff(table[:, 0]) <= 0.0).any():
        raise PalpateError(f"{path}: times must increase", mend="sort the rows by time")
    arrived = table[table[:, 1] >= 0.0, 1]
    if len(arrived) and np.median(arrived) > _LONG:
        raise PalpateError(f"{path}: the median delay is {np.median(arrived):g} s", mend="write seconds: 0.041, not 41")
    return out


def _columns(path: Path, names: list[str]) -> tuple[int, int]:
    """Columns of time and delay by their names."""
    plain = [name.strip().lower() for name in names]
    if len(plain) <= 2:
        return 0, 1
    if "time" in plain and "delay" in plain:
        return plain.index("time"), plain.index("delay")
    raise PalpateError(f"{path}: no columns time and delay", why=f"the columns are {', '.join(names)[:100]}",
                       mend="name them so, in seconds; for captured packets give the FILE.pcap")  # fmt: skip


def _arrivals(path: Path) -> Array:
    """Times of the packets of a pcap file [s]."""
    data = limits.read_bytes(path, limits.MOST_TABLE)
    for order in "<>":
        if len(data) >= 24 and (magic := struct.unpack(order + "I", data[:4])[0]) in _MAGIC:
            break
    else:
        mend = "record it with tcpdump -w FILE.pcap (pcapng: editcap -F pcap)"
        raise PalpateError(f"{path}: this is no pcap file", mend=mend)
    times, at = [], 24
    while at + 16 <= len(data):
        seconds, fraction, length = struct.unpack(order + "III", data[at : at + 12])
        times.append(seconds + _MAGIC[magic] * fraction)
        at += 16 + length
    return np.array(times)


def _of_arrivals(path: Path, arrivals: Array) -> Trace:
    """Delays of a stream with a constant period, relative to the earliest packets."""
    if len(arrivals) < _LEAST:
        raise PalpateError(f"{path}: {len(arrivals)} packets", mend="record at least a few seconds of one stream")
    arrivals = np.sort(arrivals) - arrivals.min()
    period = float(np.median(np.diff(arrivals)))
    if not period > 0.0:
        raise PalpateError(
            f"{path}: packets have no period", mend="filter the capture to one stream with a constant rate"
        )
    slots = int(arrivals[-1] / period) + 1
    if slots > _SPARSE * len(arrivals):
        mend = "filter the capture to one stream with a constant rate"
        raise PalpateError(f"{path}: {len(arrivals)} packets in {slots} periods of {period:g} s", mend=mend)
    number, period = _numbered(arrivals, period)
    lag = arrivals - period * number
    middles = np.arange(0, len(lag), _WINDOW // 8)
    floors = [np.quantile(lag[max(i - _WINDOW, 0) : i + _WINDOW], _EARLIEST) for i in middles]
    late = np.full(int(number[-1]) + 1, -1.0)
    late[number] = np.maximum(lag - np.interp(np.arange(len(lag)), middles, floors), 0.0)
    return [(period * k, float(delay)) for k, delay in enumerate(late)]


def _numbered(arrivals: Array, period: float) -> tuple[NDArray[np.int64], float]:
    """Number of each packet, and the sender's period [s], near the given one.

    Of several periods to begin with, the one is taken whose line fits the first packets best: one that loses or gains a
    packet on the way leaves a step.
    """
    some = arrivals[:_MANY]
    begun = [_fitted(some, period * share) for share in np.linspace(1.0 - _UNSURE, 1.0 + _UNSURE, _BEGINNINGS)]
    near = [one for one in begun if abs(one[1] / period - 1.0) <= _FAR] or begun
    best = min(near, key=lambda one: float(np.std(some - one[1] * one[0])))
    number, period = _fitted(arrivals, best[1])
    return number - number[0], period


def _fitted(arrivals: Array, period: float) -> tuple[NDArray[np.int64], float]:
    """Numbers and period by lines through longer and longer parts of a stream.

    A packet that comes more than half a period later than the others shares its number with the next one: each has the
    latest that is still free.
    """
    n, first = _LEAST, float(arrivals[0])
    while True:
        part = arrivals[:n]
        for _ in range(_FITS):
            order = np.arange(len(part))
            number = np.round((part - first) / period).astype(np.int64) - order
            number = np.minimum.accumulate(number[::-1])[::-1] + order
            period, first = (float(one) for one in np.polyfit(number, part, 1))
        if n >= len(arrivals):
            return number, period
        n *= 2
