"""Reads the snapshots of a record: the shape of soft objects is unpacked when it is asked for, chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from palpate.record.extra import poses_of
from palpate.record.mcap_scan import Index, Place
from palpate.record.snapshots import BODY, FRAMES, QUANTUM, SHAPE, BodyTrack, Track, joints_of, shape_of


def track_of(index: Index, topic: str) -> Track | None:
    """The snapshots of a topic; None if the file has none, or another tool has rewritten them in another layout."""
    number = next((k for k, one in index.channels.items() if one.topic == topic), None)
    schema = None if number is None else index.schema_of(number)
    if number is None or schema is None:
        return None
    try:
        if schema.name == SHAPE:
            return _shapes(index, number)
        found = [(message.log_time, joints_of(bytes(message.data))) for message in index.messages({number})]
    except ValueError:
        return None
    if len({value.shape for _, value in found}) != 1:
        return None
    return Track(np.array([t for t, _ in found]) / 1e9, np.stack([value for _, value in found]))


def bodies_of(index: Index) -> BodyTrack | None:
    """The poses of rigid bodies; None if the file has none, or another tool has rewritten them in another layout."""
    number = next((k for k, one in index.channels.items() if one.topic == FRAMES), None)
    if number is None:
        return None
    times, rows, names = [], [], set()
    for message in index.messages({number}):
        if BODY.encode() not in message.data:
            continue
        try:
            poses = poses_of(bytes(message.data))
        except ValueError:
            return None
        names.add(tuple(poses))
        times.append(message.log_time)
        rows.append(np.stack(list(poses.values())))
    if len(names) != 1:
        return None
    values = np.stack(rows)
    turns = np.einsum("knc,knc->kn", values[1:, :, 3:], values[:-1, :, 3:])  # q and -q are the same rotation
    values[1:, :, 3:] *= np.cumprod(np.where(turns < 0.0, -1.0, 1.0), axis=0)[..., None]
    return BodyTrack(tuple(name.removeprefix(BODY) for name in names.pop()), Track(np.array(times) / 1e9, values))


def _shapes(index: Index, number: int) -> Track | None:
    times: list[int] = []
    places: list[tuple[Place | None, int]] = []
    forms: set[tuple[int, ...]] = set()
    for place in [*index.chunks, None]:
        for k, (time, shape) in enumerate(_in_place(index, number, place)):
            times.append(time)
            places.append((place, k))
            forms.add(shape.shape)
    if len(forms) != 1:
        return None
    return Track(np.array(times) / 1e9, Shapes(index, number, places, forms.pop()), QUANTUM)


def _in_place(index: Index, number: int, place: Place | None) -> Iterator[tuple[int, npt.NDArray[np.int16]]]:
    """Time [ns] and shape of each message in a chunk, or outside of any for None."""
    if place is None:
        messages = (message for message in index.loose if message.channel_id == number)
    else:
        messages = (message for message in index.messages_in(place, {number}))
    for message in messages:
        yield message.log_time, shape_of(bytes(message.data))


class Shapes:
    """The shapes of a soft object (k, n, 3), of which one chunk is in memory at a time.

    Args:
        index: of the file.
        number: of the channel.
        places: chunk of each shape, and its number in it.
        form: (n, 3).
    """

    def __init__(
        self, index: Index, number: int, places: list[tuple[Place | None, int]], form: tuple[int, ...]
    ) -> None:
        self._index, self._number, self._places = index, number, places
        self.shape = (len(places), *form)
        self._newest: tuple[Place | None, list[npt.NDArray[np.int16]]] | None = None

    def __len__(self) -> int:
        """Number of snapshots."""
        return len(self._places)

    def __getitem__(self, k: int) -> npt.NDArray[np.int16]:
        """Shape number k (n, 3)."""
        place, number = self._places[k]
        if self._newest is None or self._newest[0] is not place:
            self._newest = (place, [shape for _, shape in _in_place(self._index, self._number, place)])
        return self._newest[1][number]

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[np.generic]:
        """All of them."""
        return np.array([self[k] for k in range(len(self))], dtype=dtype)
