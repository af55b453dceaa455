"""Replaces values of a scene by path, for example ``objects.0.stiffness``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from palpate.base.arrays.plain import Content
from palpate.base.errors import Place, SceneError, format_place
from palpate.base.values.wording import explain
from palpate.scene.operator import load_hand
from palpate.scene.scene import Scene


def override(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """A copy of the scene with overridden values, checked like a scene file; the scene itself without overrides.

    Args:
        scene: the original, which does not change.
        overrides: values by path, e.g. ``{"objects.0.stiffness": 500.0}``. Missing sections are added; entries of
            lists must exist.

    Raises:
        SceneError: a path does not exist, or a value is invalid.
    """
    if not overrides:
        return scene
    data = scene.model_dump(mode="json", exclude_unset=True)
    if "operator.hand" in overrides:
        _drop_hand_values(scene, data)
    for path, value in overrides.items():
        place = tuple(int(part) if part.isdecimal() else part for part in path.split("."))
        if place[0] == "preset":
            mend = "load the scene with the other preset"
            why = "a preset fills in keys that a file leaves out"
            raise SceneError("preset cannot be overridden", why=why, mend=mend)
        _put(data, place, value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value)
    try:
        made = Scene.validated(data, {"folder": Path(scene.file).parent})
    except ValidationError as error:
        raise explain.scene_error(error, Scene, f"{scene.title} with {', '.join(overrides)}", {}) from None
    return made.with_file_of(scene)


def _put(data: Any, place: Place, value: Any) -> None:
    for depth, part in enumerate(place):
        last = depth + 1 == len(place)
        if isinstance(data, list):
            if not isinstance(part, int) or part >= len(data):
                raise SceneError(
                    f"there is no {format_place(place[: depth + 1])} to override",
                    why=f"{format_place(place[:depth])} has {len(data)} entries, counted from 0",
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


def _drop_hand_values(scene: Scene, data: Content) -> None:
    """Remove the values filled in from the present hand, which would override those of the new hand."""
    present = load_hand(scene.operator.hand, Path(scene.file).parent)
    for key in ("mass", "damping", "stiffness"):
        if data.get("operator", {}).get(key) == getattr(present, key):
            del data["operator"][key]
