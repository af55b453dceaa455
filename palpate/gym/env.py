"""One environment of Gymnasium."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from palpate.gym.observation import Observation
from palpate.gym.vector import PalpateVectorEnv


class PalpateEnv(gymnasium.Env[Observation, NDArray[np.float64]]):
    """An instrument that a policy moves, in a scene and with a task; arguments as of `PalpateVectorEnv`."""

    metadata = {"render_modes": []}  # noqa: RUF012 - as gymnasium names it

    def __init__(self, **kwargs: Any) -> None:
        self._one = PalpateVectorEnv(1, **{"workers": 1, **kwargs})
        self.action_space = self._one.single_action_space
        self.observation_space = self._one.single_observation_space

    @property
    def instruments(self) -> Any:
        """The instrument, for its ticks (`Instruments`)."""
        return self._one.instruments

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; the same seed gives the same episode."""
        super().reset(seed=seed)
        observed, info = self._one.reset(seed=[seed])
        return _first(observed), {**info, "is_success": False}

    def step(self, action: NDArray[np.float64]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One step; the values are those of the first of several environments."""
        one = self._one
        observed, reward, done, cut, _ = one.step(np.asarray(action, dtype=np.float64)[None])
        return _first(observed), float(reward[0]), bool(done[0]), bool(cut[0]), {"is_success": bool(done[0])}

    def close(self) -> None:
        """End the threads."""
        self._one.close()


def _first(observed: Observation) -> Observation:
    return {name: values[0] for name, values in observed.items()}
