"""Writes a LeRobot data set episode by episode: version 3.0 (many episodes a file) or 2.1 (one file an episode).

The files are those that the library lerobot reads; the library itself is not needed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.errors import MissingExtraError, RecordError
from palpate.export.formats.lerobot.columns import Column
from palpate.export.formats.lerobot.statistics import Moments, joined, moments, of_columns
from palpate.export.video.film import Clip

DATA_MB, VIDEO_MB, IN_CHUNK = 100, 200, 1000
"""Largest files [MB], and files of a chunk, as lerobot has them."""
_COUNTERS = {"timestamp": "float32", "frame_index": "int64", "episode_index": "int64", "index": "int64",
             "task_index": "int64"}  # fmt: skip

_TASKS = {
    "index_columns": ["task"], "column_indexes": [], "pandas_version": "2.2.0",
    "columns": [{"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy, "metadata": None}
                for name, kind, numpy in (("task_index", "int64", "int64"), ("task", "unicode", "object"))],
}  # fmt: skip
"""Tells pandas that the texts of the tasks are the index of their table, as lerobot expects."""


@dataclass
class _Entry:
    """An episode that was written."""

    task: str
    length: int
    begin: int  # number of its first frame in the data set
    failed: bool
    source: str
    moments: dict[str, Moments]
    file: int = 0  # of its frames
    videos: dict[str, Moments] = field(default_factory=dict)  # of the colours, by camera; a file an episode


class DataSet:
    """A LeRobot data set in a folder.

    Args:
        folder: an empty folder.
        version: ``3.0`` or ``2.1``.
        fps: frames per second.
        robot: type of the robot, for `info.json`.
    """

    def __init__(self, folder: Path, version: str, fps: int, robot: str) -> None:
        try:
            import pyarrow as pa
            import pyarrow.parquet as pq
        except ImportError:
            raise MissingExtraError("pyarrow, which writes LeRobot data sets,", "learning") from None
        self._pa, self._pq = pa, pq
        self.folder, self.version, self.fps, self.robot = folder, version, fps, robot
        self.entries: list[_Entry] = []
        self.features: dict[str, dict[str, Any]] = {}
        """The features of `info.json`, known from the first episode on."""
        self._tasks: dict[str, int] = {}
        self._writer: Any = None
        self._file = 0
        (folder / "meta").mkdir()
        (folder / "videos").mkdir()  # also without films: the validator of Open-H refuses a data set without it

    @property
    def frames(self) -> int:
        """Number of frames so far."""
        return self.entries[-1].begin + self.entries[-1].length if self.entries else 0

    def add(
        self,
        columns: Mapping[str, Column],
        task: str,
        failed: bool = False,
        source: str = "",
        clips: Mapping[str, Clip] | None = None,
    ) -> None:
        """Write one episode.

        Args:
            columns: its features, each with the same number of frames.
            task: its instruction.
            failed: True puts it into the split `failure`.
            source: where it came from, for the table of episodes and messages.
            clips: films by the name of their feature; their files are moved.

        Raises:
            RecordError: its features are not those of the episodes before.
        """
        self._require_same(columns, source, clips or {})
        n = len(next(iter(columns.values())).values)
        entry = _Entry(task, n, self.frames, failed, source, {})
        counters = self._counters(n, len(self.entries), entry.begin, self._tasks.setdefault(task, len(self._tasks)))
        entry.moments = of_columns(columns) | of_columns(counters)
        entry.file = self._write(self._table({**columns, **counters}))
        for camera, clip in (clips or {}).items():
            self._take(camera, clip, len(self.entries))
            entry.videos[camera] = moments(clip.samples)
        self.entries.append(entry)

    def finish(self, splits: Mapping[str, str]) -> None:
        """Write the descriptions of the whole data set."""
        if self._writer is not None:
            self._writer.close()
        (self._describe_30 if self.version == "3.0" else self._describe_21)()
        self._json("meta/info.json", self._info(splits))

    def _counters(self, n: int, episode: int, begin: int, task: int) -> dict[str, Column]:
        k = np.arange(n, dtype=np.int64)
        values: dict[str, Any] = {
            "timestamp": (k / self.fps).astype(np.float32), "frame_index": k,
            "episode_index": np.full(n, episode, dtype=np.int64), "index": begin + k,
            "task_index": np.full(n, task, dtype=np.int64),
        }  # fmt: skip
        return {name: Column(values[name][:, None], ()) for name in _COUNTERS}

    def _take(self, camera: str, clip: Clip, episode: int) -> None:
        """Move the film of an episode to its place."""
        name = self._path_21("videos", episode, ".mp4", camera)
        if self.version == "3.0":
            name = _path_30(f"videos/{camera}", episode, ".mp4")
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        clip.file.replace(file)

    def _require_same(self, columns: Mapping[str, Column], source: str, clips: Mapping[str, Clip]) -> None:
        features: dict[str, dict[str, Any]] = {
            name: {"dtype": c.dtype, "shape": [len(c.names)], "names": list(c.names)}
            | ({"info": dict(c.info)} if c.info else {})
            for name, c in columns.items()
        }
        features |= {name: _of_video(clip, self.fps) for name, clip in clips.items()}
        features |= {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in _COUNTERS.items()}
        if not self.features:
            self.features = features
        wrong = [name for name in {**self.features, **features} if self.features.get(name) != features.get(name)]
        if wrong:
            what = f"{wrong[0]} is not as in the episodes before"
            why = f"before: {_words(self.features.get(wrong[0]))}; here: {_words(features.get(wrong[0]))}"
            raise RecordError(
                what, where=source, why=why, mend="export runs of other arms into a data set of their own"
            )

    def _table(self, columns: Mapping[str, Column]) -> Any:
        pa, arrays, fields = self._pa, [], []
        for name, column in columns.items():
            values = column.values
            kind = {"float32": pa.float32(), "int64": pa.int64(), "string": pa.string()}[column.dtype]
            if isinstance(values, list):
                array = pa.array(values, kind)
            elif values.shape[1] == 1:
                array = pa.array(values[:, 0], kind)
            else:
                array = pa.FixedSizeListArray.from_arrays(pa.array(values.reshape(-1), kind), values.shape[1])
            arrays.append(array)
            fields.append(pa.field(name, array.type))
        return pa.Table.from_arrays(arrays, schema=pa.schema(fields))

    def _write(self, table: Any) -> int:
        """Write the frames of an episode; returns the number of their file."""
        if self.version == "2.1":
            file = self.folder / self._path_21("data", len(self.entries), ".parquet")
            file.parent.mkdir(parents=True, exist_ok=True)
            self._pq.write_table(table, file, compression="snappy")
            return len(self.entries)
        file = self.folder / _path_30("data", self._file)
        if self._writer is not None and file.stat().st_size > DATA_MB * 1e6:
            self._writer.close()
            self._writer, self._file = None, self._file + 1
            file = self.folder / _path_30("data", self._file)
        if self._writer is None:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._writer = self._pq.ParquetWriter(file, table.schema, compression="snappy")
        self._writer.write_table(table)  # one group of rows an episode: readers fetch it alone
        return self._file

    def _path_21(self, kind: str, episode: int, ending: str, camera: str = "") -> str:
        middle = f"/{camera}" if camera else ""
        return f"{kind}/chunk-{episode // IN_CHUNK:03d}{middle}/episode_{episode:06d}{ending}"

    def _describe_30(self) -> None:
        pa = self._pa
        self._json("meta/stats.json", self._stats())
        tasks = pa.table({"task_index": list(self._tasks.values()), "task": list(self._tasks)})
        tasks = tasks.replace_schema_metadata({"pandas": json.dumps(_TASKS)})
        self._pq.write_table(tasks, self.folder / "meta/tasks.parquet")
        rows = [self._row_30(k, entry) for k, entry in enumerate(self.entries)]
        file = self.folder / _path_30("meta/episodes", 0)
        file.parent.mkdir(parents=True)
        self._pq.write_table(pa.Table.from_pylist(rows), file)

    def _row_30(self, k: int, entry: _Entry) -> dict[str, Any]:
        row: dict[str, Any] = {
            "episode_index": k, "tasks": [entry.task], "length": entry.length, "source": entry.source,
            "data/chunk_index": entry.file // IN_CHUNK, "data/file_index": entry.file % IN_CHUNK,
            "dataset_from_index": entry.begin, "dataset_to_index": entry.begin + entry.length,
            "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0,
        }  # fmt: skip
        for camera in entry.videos:
            row |= {
                f"videos/{camera}/chunk_index": k // IN_CHUNK, f"videos/{camera}/file_index": k % IN_CHUNK,
                f"videos/{camera}/from_timestamp": 0.0, f"videos/{camera}/to_timestamp": entry.length / self.fps,
            }  # fmt: skip
        for name, lists in _lists(entry.moments, entry.videos).items():
            row |= {f"stats/{name}/{key}": values for key, values in lists.items()}
        return row

    def _describe_21(self) -> None:
        tasks = [{"task_index": k, "task": task} for task, k in self._tasks.items()]
        self._lines("meta/tasks.jsonl", tasks)
        episodes = [{"episode_index": k, "tasks": [e.task], "length": e.length} for k, e in enumerate(self.entries)]
        self._lines("meta/episodes.jsonl", episodes)
        stats = [{"episode_index": k, "stats": _lists(e.moments, e.videos)}
                 for k, e in enumerate(self.entries)]  # fmt: skip
        self._lines("meta/episodes_stats.jsonl", stats)

    def _stats(self) -> dict[str, Any]:
        first = self.entries[0]
        return _lists(
            {name: joined([entry.moments[name] for entry in self.entries]) for name in first.moments},
            {name: joined([entry.videos[name] for entry in self.entries]) for name in first.videos},
        )

    def _info(self, splits: Mapping[str, str]) -> dict[str, Any]:
        cameras = [name for name, one in self.features.items() if one["dtype"] == "video"]
        info: dict[str, Any] = {
            "codebase_version": f"v{self.version}", "robot_type": self.robot, "fps": self.fps,
            "total_episodes": len(self.entries), "total_frames": self.frames, "total_tasks": len(self._tasks),
            "chunks_size": IN_CHUNK, "splits": dict(splits),
        }  # fmt: skip
        if self.version == "3.0":
            pattern = "chunk-{chunk_index:03d}/file-{file_index:03d}"
            info |= {
                "data_files_size_in_mb": DATA_MB, "video_files_size_in_mb": VIDEO_MB,
                "data_path": f"data/{pattern}.parquet", "video_path": f"videos/{{video_key}}/{pattern}.mp4",
            }  # fmt: skip
        else:
            chunk, episode = "chunk-{episode_chunk:03d}", "episode_{episode_index:06d}"
            info |= {
                "total_videos": len(cameras) * len(self.entries),
                "total_chunks": -(-len(self.entries) // IN_CHUNK),
                "data_path": f"data/{chunk}/{episode}.parquet",
                "video_path": f"videos/{chunk}/{{video_key}}/{episode}.mp4",
            }
        return info | {"features": self.features}

    def _json(self, name: str, values: Any) -> None:
        (self.folder / name).write_text(json.dumps(values, indent=4, allow_nan=False) + "\n", encoding="utf-8")

    def _lines(self, name: str, rows: list[dict[str, Any]]) -> None:
        text = "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)
        (self.folder / name).write_text(text, encoding="utf-8")


def _path_30(kind: str, file: int, ending: str = ".parquet") -> str:
    return f"{kind}/chunk-{file // IN_CHUNK:03d}/file-{file % IN_CHUNK:03d}{ending}"


def _lists(columns: Mapping[str, Moments], videos: Mapping[str, Moments]) -> dict[str, Any]:
    """Statistics as LeRobot stores them; those of a film have a number for each colour, (3, 1, 1)."""
    found: dict[str, Any] = {name: one.lists() for name, one in columns.items()}
    for name, one in videos.items():
        lists = one.lists()
        found[name] = {key: [[[v]] for v in values] if key != "count" else values for key, values in lists.items()}
    return found


def _of_video(clip: Clip, fps: int) -> dict[str, Any]:
    """The feature of a film."""
    height, width = clip.size
    info = {"video.height": height, "video.width": width, "video.codec": "h264", "video.pix_fmt": "yuv420p",
            "video.fps": fps, "video.channels": 3, "video.is_depth_map": False, "has_audio": False}  # fmt: skip
    return {"dtype": "video", "shape": [height, width, 3], "names": ["height", "width", "channels"], "info": info}


def _words(feature: dict[str, Any] | None) -> str:
    if feature is None:
        return "absent"
    names = feature["names"] or ["a number"]
    return f"{len(names)} x {feature['dtype']} ({', '.join(names[:4])}{', ...' if len(names) > 4 else ''})"
