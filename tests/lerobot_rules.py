"""Rules of LeRobot and of Open-H-Embodiment for a data set, written from their pages and not from our writer."""

import json
from pathlib import Path

import pyarrow.parquet as pq

COUNTERS = {"timestamp", "frame_index", "episode_index", "index", "task_index"}
SECTIONS = ("synchronization", "dataset description", "collection procedure", "robot", "sensor")


def faults(folder: Path, images: bool = False) -> list[str]:
    """Messages for each rule that a data set violates."""
    info = json.loads((folder / "meta/info.json").read_text())
    version = info["codebase_version"]
    found = [f"no {name}/" for name in ("data", "meta", "videos") if not (folder / name).is_dir()]
    files = {
        "v3.0": ("stats.json", "tasks.parquet", "episodes/chunk-000/file-000.parquet"),
        "v2.1": ("episodes.jsonl", "tasks.jsonl", "episodes_stats.jsonl"),
    }[version]
    found += [f"no meta/{name}" for name in (*files, "README.md") if not (folder / "meta" / name).is_file()]
    text = (folder / "meta/README.md").read_text().lower()
    found += [f"README without {word}" for word in SECTIONS if word not in text]
    found += [f"no feature {name}" for name in ("action", "observation.state") if name not in info["features"]]
    found += [f"no split {name}" for name in ("train", "val", "test") if name not in info["splits"]]
    found += ["fewer than 20 frames/s"] if info["fps"] < 20 else []
    found += ["no robot_type"] if not info.get("robot_type") else []
    found += [f"{name}: not ASCII, or with a slash" for name in info["features"] if not name.isascii() or "/" in name]
    pictures = {n: f for n, f in info["features"].items() if n.startswith("observation.images.")}
    found += ["no pictures"] if images and not pictures else []
    found += [f"{n}: {f['shape']} below 480" for n, f in pictures.items() if min(f["shape"][:2]) < 480]
    return found + _faults_of_data(folder, info)


def _faults_of_data(folder: Path, info: dict) -> list[str]:
    found, frames, episodes = [], 0, set()
    for file in sorted((folder / "data").rglob("*.parquet")):
        table = pq.read_table(file)
        wanted = {name for name, one in info["features"].items() if one["dtype"] != "video"}
        found += [f"{file.name}: columns {set(table.column_names) ^ wanted}"] * (set(table.column_names) != wanted)
        found += [f"no counter {name}" for name in COUNTERS - set(table.column_names)]
        for name, one in info["features"].items():
            if one["dtype"] == "video" or name not in table.column_names:
                continue
            kind, size = table.schema.field(name).type, one["shape"][0]
            if len(one["shape"]) != 1 or (one["names"] is not None and len(one["names"]) != size):
                found.append(f"{name}: {one['names']} for the shape {one['shape']}")
            fits = str(kind) == {"float32": "float", "int64": "int64", "string": "string"}[one["dtype"]]
            if size > 1:
                fits = str(kind.value_type) == "float" and kind.list_size == size
            found += [f"{name}: {kind} for {one}"] * (not fits)
        t = table["timestamp"].to_numpy() - table["frame_index"].to_numpy() / info["fps"]
        found += ["timestamp is not frame_index / fps"] * bool((abs(t) > 1e-4).any())
        index = table["index"].to_numpy()
        found += ["index does not count the frames"] * (list(index) != list(range(frames, frames + len(index))))
        frames += len(index)
        episodes |= set(table["episode_index"].to_pylist())
    found += [f"{frames} frames, told {info['total_frames']}"] * (frames != info["total_frames"])
    found += [f"episodes {episodes}"] * (episodes != set(range(info["total_episodes"])))
    ends = [tuple(map(int, span.split(":"))) for span in info["splits"].values()]
    found += [f"splits {info['splits']}"] * ([0, *(b for _, b in ends)] != [*(a for a, _ in ends), ends[-1][1]])
    found += ["splits leave episodes out"] * (ends[-1][1] != info["total_episodes"])
    return found
