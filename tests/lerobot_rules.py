"""Rules of LeRobot and of Open-H-Embodiment for a data set, written from their pages and not from our writer."""

import json
from pathlib import Path

import numpy as np
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


POSE = ["x", "y", "z", "qx", "qy", "qz", "qw", "gripper"]
WRENCH = ["fx", "fy", "fz", "tx", "ty", "tz"]
SPLITS = {"train", "val", "test", "recovery", "failure"}


def faults_of_open_h(folder: Path, arms: int = 1) -> list[str]:
    """Messages for each name, size and meaning that is not as the pages of Open-H-Embodiment v2 state it.

    Its own validator cannot be had; these are its documented rules, without the library.
    """
    info = json.loads((folder / "meta/info.json").read_text())
    features, table = info["features"], pq.read_table(sorted((folder / "data").rglob("*.parquet"))[0])
    wanted = {
        "observation.state": ("float32", POSE), "action": ("float32", POSE),
        "observation.meta.force_torque": ("float32", WRENCH), "observation.meta.force_torque.mtm": ("float32", WRENCH),
    }  # fmt: skip
    found = [f"no {name}" for name in wanted if name not in features]
    for name, (kind, parts) in wanted.items():
        one = features.get(name, {"dtype": kind, "shape": [], "names": []})
        own = [part.split(".")[-1] for part in one["names"]]
        wrong = one["dtype"] != kind or one["shape"] != [arms * len(parts)] or own != arms * parts
        found += [f"{name}: {one['dtype']} {one['shape']} {one['names']}"] * wrong
    for name in wanted:
        about = features.get(name, {}).get("info", {})
        keys = ("units", "frame", "sensor") if "force" in name else ("units", "frame")
        found += [f"{name}: no {key} in its info" for key in keys if not about.get(key)]
    texts = [name for name, one in features.items() if one["dtype"] == "string"]
    found += ["no instruction.text"] * ("instruction.text" not in texts)
    tools = [name for name in texts if name.startswith("observation.meta.tool.")]
    found += [f"tools {tools} for {arms} arms"] * (len(tools) != arms)
    stamps = {name: one for name, one in features.items() if name.endswith("_stamp_ns")}
    found += ["no host_stamp_ns"] * ("observation.meta.host_stamp_ns" not in stamps)
    found += [f"{name}: {one['dtype']}" for name, one in stamps.items() if one["dtype"] != "int64"]
    for name in stamps:
        values = np.array(table[name].to_pylist())
        jumps = np.diff(values)[np.diff(np.array(table["episode_index"].to_pylist())) == 0]
        found += [f"{name} goes back"] * bool((jumps < 0).any())
    for name in ("observation.state", "action"):
        if name in features:
            q = np.array(table[name].to_pylist()).reshape(-1, arms, 8)[..., 3:7]
            away = np.abs(np.linalg.norm(q, axis=-1) - 1.0)
            found += [f"{name}: quaternions are not of length 1"] * bool(np.nanmax(away, initial=0.0) > 1e-3)
    found += [f"splits {sorted(set(info['splits']) - SPLITS)}"] * bool(set(info["splits"]) - SPLITS)
    films = [name for name, one in features.items() if one["dtype"] == "video"]
    found += [f"film {n}" for n in films if not n.startswith("observation.images.endoscope.")]
    if films:
        camera = json.loads((folder / "meta/calibration/camera_intrinsics.json").read_text())
        for name in films:
            eye = camera.get(name.removeprefix("observation.images."), {})
            found += [f"{name}: no {key}" for key in ("fx", "fy", "cx", "cy", "distortion_model") if key not in eye]
    return found
