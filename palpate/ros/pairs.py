"""The pairs of a scene whose hands are on arms of ROS 2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from palpate.base.errors import PalpateError
from palpate.ros.haptics import Devices, Limits
from palpate.ros.plant import CrtkPlant
from palpate.scene.scene import Scene


def plants_of(
    scene: Scene,
    limits: Limits | None = None,
    only: Sequence[str] = (),
    console: str = "console",
    context: Mapping[str, Any] | None = None,
) -> dict[str, CrtkPlant]:
    """The arms of the pairs that name them (`devices`), for `palpate.PairsSession`; the others have a driver.

        with palpate.PairsSession(scene, plants=plants_of(scene)) as pairs:
            pairs.run(60.0)

    Args:
        scene: a scene with the section `pairs`.
        limits: caps and rates of every arm.
        only: names of the pairs to run; all when left out.
        console: CRTK name of the console.
        context: arguments of the ROS context (`network`, `domain`, `arguments`).

    Raises:
        PalpateError: a pair names neither arms nor a driver, or none of them is on ROS 2.
    """
    named = devices_of(scene)
    found = {
        name: CrtkPlant(scene.pair(name), Devices(one.leader, one.follower, one.teleop, console, name), limits, context)
        for name, one in named.items()
        if not only or name in only
    }
    if not found:
        mend = "palpate run renders devices; add devices: {leader: MTML} to a pair whose hand is on an arm"
        raise PalpateError("no pair of the scene is on ROS 2", where=scene.where("pairs"), mend=mend)
    return found


def devices_of(scene: Scene) -> dict[str, Devices]:
    """The CRTK names of each pair that has no driver, by its name; empty for a scene without pairs.

    Raises:
        PalpateError: a pair names neither arms nor a driver, or both; the message names the pair and the line.
    """
    found = {}
    for name, pair in scene.each_pair().items() if scene.pairs else ():
        devices, driver = scene.pairs[name].devices, pair.arms.leader.driver
        if devices is not None and driver is not None:
            what = f"the hand of pair {name} is on {devices.leader} (devices) and on {driver} (driver)"
            raise PalpateError(what, where=scene.where("pairs", name), mend="leave one of them out")
        if devices is not None:
            found[name] = Devices(devices.leader, devices.follower, devices.teleop, pair=name)
        elif driver is None:
            raise PalpateError(
                f"pair {name} does not name its arms on ROS 2",
                where=scene.where("pairs", name),
                mend="add devices: {leader: MTML, follower: PSM2, teleop: MTML_PSM2}, or the driver of a device",
            )
    return found
