"""A scene with some of its values replaced."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from palpate.base.errors import PalpateError
from palpate.scene import Scene
from palpate.scene.overrides import override


@dataclass(frozen=True)
class Variation:
    """One run of `simulate`.

    Args:
        scene: a scene, or the path of a scene file.
        overrides: values by path in the scene file, with dots and list indices: ``{"objects.0.stiffness": 500.0,
            "mapping.scale": 0.3}``. Units are those of the scene file.
        seed: seed of all random numbers of the run; the scene's when left out.
    """

    scene: Scene | str | os.PathLike[str]
    overrides: Mapping[str, Any] = field(default_factory=dict)
    seed: int | None = None

    def resolved(self) -> Scene:
        """The scene with the overrides applied.

        Raises:
            SceneError: the scene cannot be read, or a value is invalid.
        """
        base = self.scene if isinstance(self.scene, Scene) else Scene.load(self.scene)
        return override(base, self.overrides)

    def __str__(self) -> str:
        """The overrides and the seed, for messages."""
        parts = [f"{place} = {value}" for place, value in self.overrides.items()]
        return ", ".join(parts + ([f"seed {self.seed}"] if self.seed is not None else [])) or "the scene as it is"


Runs = Scene | Variation | str | os.PathLike[str] | Iterable[Scene | Variation | str | os.PathLike[str]]


def variations(runs: Runs) -> list[Variation]:
    """The `runs` argument of `simulate` as a list of variations. Each scene file is read once.

    Raises:
        SceneError: a scene file cannot be read. PalpateError: the list is empty.
    """
    single = isinstance(runs, (Scene, Variation, str, os.PathLike))
    listed: list[Any] = [runs] if single else list(runs)  # type: ignore[arg-type]
    if not listed:
        raise PalpateError("there is nothing to simulate", mend="give at least one scene or variation")
    files: dict[str, Scene] = {}
    found = []
    for one in listed:
        variation = one if isinstance(one, Variation) else Variation(one)
        if not isinstance(variation.scene, Scene):
            name = os.fspath(variation.scene)
            if name not in files:
                files[name] = Scene.load(name)
            variation = Variation(files[name], variation.overrides, variation.seed)
        found.append(variation)
    return found
