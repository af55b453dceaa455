"""A configuration of RViz for the nodes that render a scene: arms, markers, frames and clouds of all pairs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from palpate.ros.around.convert import WORLD
from palpate.ros.haptics import Devices
from palpate.scene.scene import Scene

_PLUGIN = "rviz_default_plugins"


def config(scene: Scene, devices: Mapping[str, Devices]) -> dict[str, Any]:
    """Contents of an .rviz file, which is YAML.

    Args:
        scene: the scene; its sensors with a topic are shown as clouds.
        devices: arms of each pair, by the name of the pair.
    """
    displays = [_display("Grid", "grid"), _display("TF", "frames", **{"Show Names": False})]
    for pair, own in devices.items():
        node = f"/{pair}/palpate" if pair else "/palpate"
        follower = own.follower.strip("/")
        for arm in (own.leader.strip("/"), f"{pair}_virtual".lstrip("_") if follower == "virtual" else follower):
            model = {"Description Source": "Topic", "TF Prefix": arm, "Visual Enabled": True}
            displays.append(
                _display(
                    "RobotModel", arm, **{"Description Topic": _topic(f"{node}/{arm}/robot_description", True)}, **model
                )
            )
        displays.append(_display("MarkerArray", f"{pair} forces".strip(), Topic=_topic(f"{node}/markers")))
    first = next(iter(devices))
    objects = f"/{first}/palpate/objects" if first else "/palpate/objects"
    displays.append(_display("MarkerArray", "objects", Topic=_topic(objects, True)))
    for name, sensor in scene.sensors.items():
        if sensor.topic is not None:
            displays.append(_display("PointCloud2", name, Topic=_topic(sensor.topic)))
    return {
        "Panels": [{"Class": f"rviz_common/{name}", "Name": name} for name in ("Displays", "Views")],
        "Visualization Manager": {
            "Class": "",
            "Displays": displays,
            "Enabled": True,
            "Global Options": {"Background Color": "48; 48; 48", "Fixed Frame": WORLD, "Frame Rate": 30},
            "Name": "root",
            "Tools": [{"Class": f"{_PLUGIN}/MoveCamera"}],
            "Value": True,
            "Views": {"Current": {"Class": f"{_PLUGIN}/Orbit", "Distance": 1.2, "Name": "Current View", "Pitch": 0.6,
                                  "Target Frame": WORLD, "Yaw": 1.2}},
        },
    }  # fmt: skip


def topics(contents: Mapping[str, Any]) -> list[str]:
    """Topics that a configuration shows."""
    shown = contents["Visualization Manager"]["Displays"]
    keys = ("Topic", "Description Topic")
    return [one[key]["Value"] for one in shown for key in keys if key in one]


def _display(kind: str, name: str, **more: Any) -> dict[str, Any]:
    return {"Class": f"{_PLUGIN}/{kind}", "Name": name, "Enabled": True, "Value": True, **more}


def _topic(name: str, latched: bool = False) -> dict[str, Any]:
    durability = "Transient Local" if latched else "Volatile"
    return {
        "Value": name, "Depth": 5, "History Policy": "Keep Last", "Reliability Policy": "Reliable",
        "Durability Policy": durability,
    }  # fmt: skip
