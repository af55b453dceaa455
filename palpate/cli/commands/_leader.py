"""The option --leader: devices instead of the leaders of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from palpate.base.errors import PalpateError

if TYPE_CHECKING:
    from palpate.scene import Scene


def with_leaders(scene: Scene, leaders: Sequence[str]) -> Scene:
    """The scene with the drivers of --leader: none, one, or PAIR=DRIVER for each hand.

    Raises:
        PalpateError: a pair is missing or unknown, or there is no such driver.
    """
    if not scene.pairs:
        if len(leaders) > 1:
            what = f"--leader is given {len(leaders)} times, and the scene has one hand"
            raise PalpateError(what, mend="give one, or a scene with a section pairs")
        return scene.with_driver(leaders[0]) if leaders else scene
    for text in leaders:
        pair, _, driver = text.partition("=")
        if pair not in scene.pairs or not driver:
            what, names = f"--leader {text} names no pair of the scene", ", ".join(scene.pairs)
            mend = f"write PAIR=DRIVER with one of {names}, e.g. {next(iter(scene.pairs))}=haply"
            raise PalpateError(what, mend=mend)
        scene = scene.with_driver(driver, pair)
    return scene
