"""Values of a scene replaced by others, named by their place: ``objects.0.stiffness``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from palpate.errors import SceneError, spell
from palpate.scene import explain
from palpate.scene.operator import hand_of
from palpate.scene.scene import Scene
from palpate.scene.text import Place


def overridden(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """A scene with other values, checked as a scene file is; the scene itself when there are none.

    Args:
        scene: left as it is.
        overrides: values by place, e.g. ``{"objects.0.stiffness": 500.0}``; sections that the scene leaves out are
            added, entries of lists must exist.

    Raises:
        SceneError: no such place, or a value that the place refuses.
    """
    if not overrides:
        return scene
    data = scene.model_dump(mode="json", exclude_unset=True)
    if "operator.hand" in overrides:
        _forget_hand(scene, data)
    for path, value in overrides.items():
        place = tuple(int(part) if part.isdigit() else part for part in path.split("."))
        if place[0] == "preset":
            mend = "load the scene with the other preset"
            raise SceneError("preset cannot be overridden", why="it fills in what a file leaves out", mend=mend)
        _put(data, place, value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value)
    try:
        made = Scene.model_validate(data, context={"folder": Path(scene.file).parent})
    except ValidationError as error:
        raise explain.scene_error(error, Scene, f"{scene.title} with {', '.join(overrides)}", {}) from None
    return made.standing_for(scene)


def _put(data: Any, place: Place, value: Any) -> None:
    for depth, part in enumerate(place):
        last = depth + 1 == len(place)
        if isinstance(data, list):
            if not isinstance(part, int) or part >= len(data):
                raise SceneError(
                    f"there is no {spell(place[: depth + 1])} to override",
                    why=f"{spell(place[:depth])} has {len(data)} entries, counted from 0",
                )
            if last:
                data[part] = value
            data = data[part]
        elif isinstance(data, dict):
            if last:
                data[str(part)] = value
            elif not isinstance(data.get(str(part)), (dict, list)):
                data[str(part)] = {}
            data = data[str(part)]


def _forget_hand(scene: Scene, data: dict[str, Any]) -> None:
    """Drop what the scene's present hand filled in: it would win over the hand that replaces it."""
    present = hand_of(scene.operator.hand, Path(scene.file).parent)
    for key in ("mass", "damping", "stiffness"):
        if data.get("operator", {}).get(key) == getattr(present, key):
            del data["operator"][key]
