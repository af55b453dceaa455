"""Exchanges the leaders of two pairs, and with them the hands on their instruments."""

from __future__ import annotations

from typing import Any

from palpate.base.errors import StateError
from palpate.scene.overrides import override
from palpate.scene.scene import Scene


def swapped(scene: Scene) -> Scene:
    """The scene with the leaders of its two pairs exchanged; everything else stays with the instrument.

    Raises:
        StateError: the scene has not two pairs. SceneError: the exchanged values contradict the scene.
    """
    if len(scene.pairs) != 2:
        what = f"swap exchanges the followers of two hands; this session has {len(scene.pairs)}"
        raise StateError(what, mend="exchange the leaders of the pairs in the scene")
    each = {name: pair.model_dump(mode="json", exclude_unset=True) for name, pair in scene.pairs.items()}
    one, other = each.values()
    _exchange(one, other, "torque")
    for section in ("arms", "devices"):
        _exchange(one.setdefault(section, {}), other.setdefault(section, {}), "leader")
        for pair in (one, other):
            keys = pair[section]
            keys.pop("teleop", None)  # it names both arms of a pair
            if not keys:
                del pair[section]
    return override(scene, {"pairs": each})


def _exchange(one: dict[str, Any], other: dict[str, Any], key: str) -> None:
    """Exchange the values of a key, also where one of both has none."""
    a, b = one.pop(key, None), other.pop(key, None)
    if b is not None:
        one[key] = b
    if a is not None:
        other[key] = a
