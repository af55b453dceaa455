"""Gains as ROS parameters, and change of scene by a service: checked like scene files, applied as a whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from palpate.base.errors import PalpateError
from palpate.scene import Scene, gains, surface
from palpate.scene.rig import check_method

if TYPE_CHECKING:
    from palpate.ros.plant import CrtkPlant
    from palpate.session import Session

_GAINS = {
    "stiffness": (0.0, 1e5, "N/m, all axes alike"),
    "damping": (0.0, 1e3, "N s/m, all axes alike"),
    "friction": (0.0, 2.0, "tangential force over normal force"),
}
_SCALES = {
    "stiffness_scale": (0.0, 2.0, "multiplies the stiffness of every object"),
    "damping_scale": (0.0, 5.0, "multiplies the damping of every object"),
}


class Swap:
    """Parameters of the node: stiffness_scale, damping_scale, following, OBJECT.stiffness|damping|friction, scene_file.

    The service ~/load_scene (std_srvs/Trigger) loads scene_file. All objects change in one step of the cycle; arms,
    mapping, caps and all other settings keep their values from the start of the node.
    """

    def __init__(self, node: Any, session: Session, plant: CrtkPlant, on_swap: Callable[[], None]) -> None:
        from std_srvs.srv import Trigger

        self._node, self._session, self._plant, self._on_swap = node, session, plant, on_swap
        self._declare()
        node.add_on_set_parameters_callback(self._set)
        node.create_service(Trigger, "~/load_scene", self._load)

    def swap(self, scene: Scene) -> None:
        """Replace the objects at the next step of the cycle.

        Raises:
            PalpateError: the scene cannot be used; nothing has changed.
        """
        session = self._session
        if session.tracking is not None:
            raise PalpateError(
                "objects cannot be replaced while they follow a tracker",
                mend="start a new session with the other scene",
            )
        gains.check_stiffness(scene)
        placed = surface.placed(scene)
        snapshot = surface.snapshot(scene, placed)
        check_method(scene, snapshot)
        try:
            self._plant.loop.set_snapshot(snapshot)
        except ValueError as error:
            raise PalpateError(
                str(error), where=scene.file, mend="correct the scene; the previous one stays active"
            ) from None
        session.rig = replace(session.rig, scene=scene, surfaces=placed, snapshot=snapshot)
        self._plant.events.append(f"at t = {float(session.latest()['t']):.3f} s: {', '.join(_gains_in_words(scene))}")
        self._on_swap()

    def _declare(self) -> None:
        controls, file = self._session.controls, self._session.rig.scene.file
        for name, (least, most, words) in _SCALES.items():
            self._number(name, getattr(controls, name), least, most, words)
        self._node.declare_parameter(
            "following", bool(controls.following), _described("render forces and follow the hand")
        )
        description = _described("scene that ~/load_scene loads: a path on this machine")
        self._node.declare_parameter("scene_file", str(Path(file).resolve()) if file else "", description)
        self._declare_objects()

    def _declare_objects(self) -> None:
        for obj in self._session.rig.scene.objects:
            for gain, (least, most, words) in _GAINS.items():
                value = getattr(obj, gain)
                name = f"{obj.name}.{gain}"
                if not self._node.has_parameter(name):
                    self._number(name, max(value) if isinstance(value, tuple | list) else value, least, most, words)

    def _number(self, name: str, value: float, least: float, most: float, words: str) -> None:
        from rcl_interfaces.msg import FloatingPointRange

        description = _described(words)
        description.floating_point_range = [FloatingPointRange(from_value=least, to_value=most, step=0.0)]
        self._node.declare_parameter(name, min(max(float(value), least), most), description)

    def _set(self, parameters: list[Any]) -> Any:
        """Apply several parameters as one change: all of them, or none with the reason."""
        from rcl_interfaces.msg import SetParametersResult

        try:
            changed = {p.name: p.value for p in parameters}
            of_objects = {k: v for k, v in changed.items() if "." in k and k.rsplit(".", 1)[1] in _GAINS}
            if of_objects:
                self.swap(_with(self._session.rig.scene, of_objects))
            controls = self._session.controls
            for name in ("stiffness_scale", "damping_scale", "following"):
                if name in changed:
                    setattr(controls, name, changed[name])
            self._session.controls = controls
        except (PalpateError, ValueError) as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _load(self, _: Any, answer: Any) -> Any:
        try:
            scene = Scene.load(self._node.get_parameter("scene_file").value)
            before = self._session.rig.scene
            arms = before.model_dump(exclude={"objects", "operator", "duration", "record", "seed"})
            other = [k for k, v in scene.model_dump(include=set(arms)).items() if v != arms[k]]
            self.swap(scene.model_copy(update={k: getattr(before, k) for k in other}))
            self._declare_objects()
            answer.success = True
            answer.message = f"objects: {', '.join(t.name for t in scene.objects)}"
            if other:
                answer.message += f"; kept from before, as they cannot change while it runs: {', '.join(other)}"
        except PalpateError as error:
            answer.success, answer.message = False, str(error)
        return answer


def _described(words: str) -> Any:
    from rcl_interfaces.msg import ParameterDescriptor

    return ParameterDescriptor(description=words)


def _with(scene: Scene, changes: dict[str, float]) -> Scene:
    """A copy of the scene with other gains, checked like a scene file. Raises SceneError."""
    data = scene.model_dump(mode="json")
    for name, value in changes.items():
        obj, gain = name.rsplit(".", 1)
        index = next((i for i, o in enumerate(scene.objects) if o.name == obj), None)
        if index is None:
            names = ", ".join(o.name for o in scene.objects)
            raise PalpateError(f"there is no object {obj!r} any more", mend=f"objects: {names}")
        data["objects"][index][gain] = value
    return Scene.parse(yaml.safe_dump(data, sort_keys=False), scene.file or "scene.yaml")


def _gains_in_words(scene: Scene) -> list[str]:
    return [f"{o.name} {max(o.stiffness):g} N/m, {max(o.damping):g} N s/m" for o in scene.objects]
