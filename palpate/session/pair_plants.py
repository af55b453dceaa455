"""The plants of several pairs: each device leads in one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations

from palpate.base.errors import DeviceError
from palpate.scene import held
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.scene.together import Rigs, build_pairs
from palpate.session.plants import Plant, plant_of


def opened(scene: Scene, given: Mapping[str, Plant] | None = None, only: Sequence[str] = ()) -> dict[str, Plant]:
    """The plant of each pair, by name.

    Args:
        scene: a scene with the section `pairs`.
        given: plants of some pairs; those of the others are named by the scene.
        only: names of the pairs; all when left out.

    Raises:
        DeviceError: a driver cannot be used, or two pairs have the same part. SceneError: there is no such pair, or the
        scene has what several hands do not move where one is on a device.
    """
    for name in (*only, *(given or {})):
        scene.pair(name)
    plants: dict[str, Plant] = {}
    for name, one in scene.each_pair().items():
        if only and name not in only:
            continue
        try:
            plants[name] = (given or {}).get(name) or plant_of(one)
        except DeviceError as error:
            where = error.where or one.where("arms", "leader", "driver")
            raise DeviceError(f"pair {name}: {error.what}", where=where, why=error.why, mend=error.mend) from None
    if any(not plant.simulated for plant in plants.values()):
        held.refuse_graspable(scene)
    _require_different(plants)
    return plants


def rigs_of(scene: Scene, plants: Mapping[str, Plant]) -> Rigs:
    """The rigs of the pairs that have a plant, which share the objects; those of devices know their rate and caps.

    The arms of the other pairs count, too: none may stand in another one.

    Raises:
        SceneError, MeshError: the scene cannot run.
    """
    devices = [name for name, plant in plants.items() if not plant.simulated]
    rigs = build_pairs(scene, made_by={name: _builder(plants[name], i) for i, name in enumerate(devices)})
    return {name: rigs[name] for name in plants}


def _builder(plant: Plant, index: int) -> Callable[[Scene, Bodies], Rig]:
    return lambda scene, bodies: plant.build(bodies, index)


def _require_different(plants: Mapping[str, Plant]) -> None:
    for (one, a), (other, b) in combinations(plants.items(), 2):
        part = next((part for part in a.hardware if part in b.hardware), None)
        if part is None:
            continue
        mend = "name another device by its serial number, or another grip: driver: {haply: {id: 04C3, grip: none}}"
        if b.driver is None:
            mend = "name another arm: devices: {leader: MTML, follower: PSM2}"
        what = f"the pairs {one} and {other} both have {part}"
        raise DeviceError(what, where=b.scene.where("arms", "leader", "driver"), mend=mend)
