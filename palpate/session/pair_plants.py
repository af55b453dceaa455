"""The plants of several pairs: each device leads in one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations

from palpate.base.errors import DeviceError, SceneError
from palpate.scene import held
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.scene.together import Rigs, build_pairs
from palpate.session.plants import Plant, plant_of


def opened(scene: Scene) -> dict[str, Plant]:
    """The plant of each pair, by name.

    Raises:
        DeviceError: a driver cannot be used, or two pairs have the same part. SceneError: the scene has what several
        hands do not move where one is on a device.
    """
    pairs = scene.each_pair()
    if any(one.arms.leader.driver is not None for one in pairs.values()):
        held.refuse_graspable(scene)
        if scene.bodies:
            what = "bodies are not moved by several hands of which one is on a device"
            mend = "leave them out, use one device, or simulate both"
            raise SceneError(what, where=scene.where("bodies"), mend=mend)
    plants: dict[str, Plant] = {}
    for name, one in pairs.items():
        try:
            plants[name] = plant_of(one)
        except DeviceError as error:
            where = error.where or one.where("arms", "leader", "driver")
            raise DeviceError(f"pair {name}: {error.what}", where=where, why=error.why, mend=error.mend) from None
    _require_different(plants)
    return plants


def rigs_of(scene: Scene, plants: Mapping[str, Plant]) -> Rigs:
    """The rigs of all pairs, which share the objects; those of devices know their rate, caps and workspace.

    Raises:
        SceneError, MeshError: the scene cannot run.
    """
    devices = [name for name, plant in plants.items() if not plant.simulated]
    return build_pairs(scene, made_by={name: _builder(plants[name], i) for i, name in enumerate(devices)})


def _builder(plant: Plant, index: int) -> Callable[[Scene, Bodies], Rig]:
    return lambda scene, bodies: plant.build(bodies, index)


def _require_different(plants: Mapping[str, Plant]) -> None:
    for (one, a), (other, b) in combinations(plants.items(), 2):
        for part in set(a.hardware) & set(b.hardware):
            what = f"the pairs {one} and {other} both have {part}"
            mend = "name another device by its serial number, or another grip: driver: {haply: {id: 04C3, grip: none}}"
            raise DeviceError(what, where=b.scene.where("arms", "leader", "driver"), mend=mend)
