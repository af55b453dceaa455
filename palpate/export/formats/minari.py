"""Minari: a data set for offline reinforcement learning, with state and forces as observation."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.errors import MissingExtraError, RecordError
from palpate.export.demonstration import Demonstration
from palpate.export.episode import episode_of
from palpate.export.formats.lerobot.alike import require_alike
from palpate.export.formats.lerobot.columns import open_h
from palpate.export.options import Options

NAME = "palpate/demonstrations-v0"
"""Name of the data set: the folder that it has within the one that is exported."""
_OBSERVED = {
    "state": "observation.state", "force": "observation.meta.force_torque", "hand": "observation.meta.force_torque.mtm",
    "peak": "observation.meta.force_peak", "contact": "observation.meta.contact",
}  # fmt: skip


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write runs as one data set, an episode each, without rewards. It opens with the folder as MINARI_DATASETS_PATH.

    Raises:
        RecordError: the runs do not fit together, or one has no two frames. MissingExtraError: minari is not installed.
    """
    try:
        import minari
        from gymnasium.spaces import Box, Dict
        from minari.data_collector import EpisodeBuffer
    except ImportError:
        raise MissingExtraError("minari, which writes its data sets,", "learning") from None
    require_alike(runs, options.mixed)
    buffers: list[Any] = []
    spaces: dict[str, Any] = {}
    for number, run in enumerate(runs):
        columns = open_h(episode_of(run, options.fps, options.task))
        seen = {key: np.asarray(columns[name].values) for key, name in _OBSERVED.items() if name in columns}
        spaces = {key: Box(-np.inf, np.inf, values.shape[1:], np.float32) for key, values in seen.items()}
        actions = np.asarray(columns["action"].values)[:-1]  # an action lies between two observations
        n = len(actions)
        if n == 0:
            what = f"the run has one frame at {options.fps} Hz, and no action, which lies between two"
            raise RecordError(what, where=str(run.path), mend="leave it out, or give a larger --fps")
        ends = np.arange(n) == n - 1
        buffers.append(EpisodeBuffer(id=number, observations=seen, actions=actions, rewards=np.zeros(n),
                                     terminations=np.zeros(n, dtype=bool), truncations=ends, infos={}))  # fmt: skip
    with _datasets_in(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that nobody is named as author
        made = minari.create_dataset_from_buffers(
            NAME, buffers, observation_space=Dict(spaces),
            action_space=Box(-np.inf, np.inf, buffers[0].actions.shape[1:], np.float32),
            algorithm_name="demonstrations", description=f"{runs[0].task}; frames at {options.fps} Hz",
        )  # fmt: skip
    return {"episodes": len(buffers), "frames": int(made.total_steps), "fps": options.fps, "dataset": NAME}


@contextmanager
def _datasets_in(folder: Path) -> Iterator[None]:
    """Let minari keep its data sets in a folder."""
    before = os.environ.get("MINARI_DATASETS_PATH")
    os.environ["MINARI_DATASETS_PATH"] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ["MINARI_DATASETS_PATH"]
        else:
            os.environ["MINARI_DATASETS_PATH"] = before
