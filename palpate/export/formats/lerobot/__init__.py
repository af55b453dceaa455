"""LeRobot data sets (v3.0, v2.1) with the forces at instrument and hand, by Open-H's names or the dVRK's."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from palpate.base.errors import PalpateError, RecordError
from palpate.export.demonstration import Demonstration
from palpate.export.episode import Episode, episode_of
from palpate.export.formats.lerobot.alike import require_alike
from palpate.export.formats.lerobot.columns import NAMINGS, Column
from palpate.export.formats.lerobot.data_set import DataSet
from palpate.export.formats.lerobot.page import page
from palpate.export.formats.lerobot.splits import ordered, splits_of
from palpate.export.options import Options
from palpate.export.video.bag_film import BagFilm
from palpate.export.video.film import Clip, Film


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write runs as one data set, an episode each; those with a fault come last, as the split `failure`.

    Raises:
        RecordError: the runs differ in rate, arms or scene, or one has fewer ticks per second than frames.
        PalpateError: an option has no meaning.
    """
    require_alike(runs, options.mixed)
    listed = ordered(runs, lambda run: bool(run.faults))
    episodes = (episode_of(run, options.fps, options.task) for run in listed)
    films = _films(listed, folder, options.fps) if options.video else None
    facts = write_episodes(episodes, folder, options, films=films)
    if options.keep_records:
        _copy(listed, folder / "records")
    return facts


def write_episodes(
    episodes: Iterable[Episode],
    folder: Path,
    options: Options,
    collected: str = "",
    films: Callable[[Episode], dict[str, Clip]] | None = None,
) -> dict[str, Any]:
    """Write episodes as one data set. Those that failed must come last.

    Args:
        episodes: the episodes, which are taken one at a time.
        folder: an empty folder.
        options: names, version and frames per second.
        collected: how they were collected, for the page of the data set; of recorded runs when left out.
        films: gives the films of an episode, by the name of their feature.
    """
    if options.names not in NAMINGS or options.version not in ("3.0", "2.1") or options.fps < 1:
        what = f"names {options.names!r}, version {options.version!r}, {options.fps} frames/s"
        raise PalpateError(what, mend="names are openh or dvrk, versions 3.0 or 2.1, frames/s 1 or more")
    data: DataSet | None = None
    first: Episode | None = None
    for episode in episodes:
        if data is None:
            first, data = episode, DataSet(folder, options.version, options.fps, _robot(episode))
        columns = NAMINGS[options.names](episode)
        _require_state(columns, episode, options.names)
        clips = {} if films is None else films(episode)
        columns |= _stamps(clips)
        data.add(columns, episode.task, episode.failed, episode.name, clips)
    if data is None or first is None:
        raise PalpateError("there is no episode to write", mend="give at least one record")
    splits = splits_of([entry.failed for entry in data.entries])
    data.finish(splits)
    (folder / "meta" / "README.md").write_text(page(data, first, splits, collected), encoding="utf-8")
    return {"episodes": len(data.entries), "frames": data.frames, "fps": options.fps, "splits": splits,
            "version": options.version, "names": options.names, "features": list(data.features)}  # fmt: skip


def _films(runs: Sequence[Demonstration], folder: Path, fps: int) -> Callable[[Episode], dict[str, Clip]]:
    """What films the episode of each run, and describes the camera of the first."""
    by_name = {run.name: run for run in runs}

    def shoot(episode: Episode) -> dict[str, Clip]:
        run = by_name[episode.name]
        film = BagFilm(run) if episode.foreign else Film(run)
        try:
            about = folder / "meta" / "calibration" / "camera_intrinsics.json"
            if not about.exists():
                about.parent.mkdir()
                about.write_text(json.dumps(film.intrinsics, indent=4) + "\n", encoding="utf-8")
            return film.shoot(episode, folder, fps)
        finally:
            film.close()

    return shoot


def _stamps(clips: Mapping[str, Clip]) -> dict[str, Column]:
    """Stamps of the pictures that cameras took, by the name of their stream."""
    return {
        f"{name.replace('.images.', '.meta.')}_stamp_ns": Column(clip.stamps[:, None], ("ns",), {"units": "ns"})
        for name, clip in clips.items()
        if clip.stamps is not None
    }


def _require_state(columns: Mapping[str, Column], episode: Episode, names: str) -> None:
    """Refuse an episode of which no state is known.

    Raises:
        RecordError: as said.
    """
    if columns["observation.state"].missing:
        what, other = ("measured_cp", "dvrk") if names == "openh" else ("measured_js", "openh")
        why = f"its follower {episode.arms[0].name} has no {what}"
        mend = f"record this topic, or give --names {other}"
        raise RecordError("the state of the arm is not known", where=episode.name, why=why, mend=mend)


def _robot(episode: Episode) -> str:
    tool = episode.arms[0].tool
    return "dvrk" if tool.startswith("psm") else tool


def _copy(runs: Sequence[Demonstration], folder: Path) -> None:
    """Copy the records of runs, which hold every tick, by the number of their episode."""
    folder.mkdir()
    for k, run in enumerate(runs):
        for arm in run.arms:
            source = getattr(arm.ticks, "path", None) or run.path
            name = f"episode_{k:06d}" + (f"_{arm.name}" if len(run.arms) > 1 else "")
            if source.is_dir():
                shutil.copytree(source, folder / name)
            else:
                shutil.copy2(source, folder / f"{name}{source.suffix}")
