"""The README of a data set, with the sections that Open-H-Embodiment asks for."""

from __future__ import annotations

from collections.abc import Mapping

from palpate.export.episode import Episode
from palpate.export.formats.lerobot.data_set import DataSet

_RECORDED = "Runs of Palpate or of a CRTK session, one episode each."
_FORCES = """\
The forces are **rendered, not measured**: they are those that Palpate computed from the scene at every tick.
`observation.meta.force_torque` is the wrench of the environment on the instrument, `.mtm` the one of the device on the
hand. A frame spans many ticks, so `force_peak` holds the least, the mean and the greatest value of each component since
the frame before, and of the size of the force (`f_min`, `f_mean`, `f_max`)."""
_SYNC = """\
All streams of an arm are computed in one loop and carry the stamp of the same tick; a frame shows the tick nearest to
its time, at most half a tick away. Values of a ROS 2 bag are the newest ones received at that time."""


def page(data: DataSet, first: Episode, splits: Mapping[str, str], collected: str = "") -> str:
    """The text of `meta/README.md`."""
    hours = data.frames / data.fps / 3600.0
    tasks = sorted({entry.task for entry in data.entries})
    tools = ", ".join(f"{arm.name}: {arm.tool}" for arm in first.arms)
    ranges = "\n".join(f"| {name} | {span} |" for name, span in splits.items())
    listed = "\n".join(f"- {task}" for task in tasks[:20]) + ("\n- ..." if len(tasks) > 20 else "")
    return f"""# A data set of Palpate

## Dataset description

{len(data.entries)} episodes, {data.frames} frames at {data.fps} frames/s, {hours:.2f} hours. LeRobot v{data.version}.

{listed}

| split | episodes |
|---|---|
{ranges}

## Collection procedure

{collected or _RECORDED}

## Robot

Type `{data.robot}`; instruments {tools}. Poses are {_frame(data)}, quaternions x y z w without jumps of their sign.

## Sensors and forces

{_FORCES}

| feature | numbers | unit and frame |
|---|---|---|
{_features(data)}

## Synchronization

{_SYNC}
"""


def _frame(data: DataSet) -> str:
    info = data.features["observation.state"].get("info", {})
    return f"in the frame: {info['frame']}" if "frame" in info else "of the joints"


def _features(data: DataSet) -> str:
    rows = []
    for name, feature in data.features.items():
        info = feature.get("info", {})
        about = ", ".join(str(info[key]) for key in ("units", "frame") if key in info)
        rows.append(f"| `{name}` | {'x'.join(map(str, feature['shape']))} {feature['dtype']} | {about} |")
    return "\n".join(rows)
