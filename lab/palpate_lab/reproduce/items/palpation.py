"""One simulated palpation with the settings of the paper, which several items read."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateWarning
from palpate.scene import Scene, rig, shipped
from palpate.session.batch import simulate
from palpate_lab.studies.figure12.work import DeepestTick

SECONDS = 5.0
SIGNALS = (
    "q", "v", "q_follower", "jaw", "tau", "tau_force", "tau_gravity", "tau_platform", "tau_friction", "tau_limits",
    "quat_LH", "p_LH", "v_LH", "p_WT", "p_WT_goal", "p_WP", "normal", "delta_x", "depth", "F_T_W", "F_spring_W",
    "F_damping_W", "F_H_L",
    "F_H_H", "F_cell_L", "p_hand_L", "lag_ms", "F_neglected", "energy_port",
)  # fmt: skip


@dataclass(frozen=True)
class Palpation:
    """The rig, and the signals of every tick by name, (n, ...) in their own units."""

    setup: rig.Rig
    t: Array
    signals: dict[str, Array]

    def __getitem__(self, name: str) -> Array:
        return self.signals[name]

    @property
    def deepest(self) -> int:
        """Index of the deepest tick."""
        return int(np.argmax(self.signals["depth"]))

    def moment(self, k: int, mesh: str) -> DeepestTick:
        """The tick k, as the pictures of ``palpate study figure12`` take it; mesh: name of the object."""
        return DeepestTick(mesh, self.setup, float(self.t[k]), {name: x[k] for name, x in self.signals.items()})


@cache
def palpation(seed: int, passivity: str = "off", **scene_keys: Any) -> Palpation:
    """The shipped scene `paper` for `SECONDS`; the preset is that of the paper, and the passivity layer is off."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PalpateWarning)
        given = Scene.load(shipped.file("paper"))
        stability = given.stability.model_copy(update={"passivity": passivity})
        scene = given.model_copy(update={"stability": stability, "seed": seed, **scene_keys})
        found = simulate([scene], SECONDS, signals=SIGNALS, signal_rate=scene.rates.haptic)
        setup = rig.build(scene)
    return Palpation(setup, found.t, {name: values[0] for name, values in found.signals.items()})


def rotations(quat: Array) -> Array:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4), w first."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quat[:, [1, 2, 3, 0]]).as_matrix())
