# What the compiled core offers to Python. Poses are (4, 4), vectors (3,), joint vectors (n,), all float64, SI units.
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# ---- loop: the table of signals, controls, real time

TICK_BYTES: int

def signals() -> list[tuple[str, int, int, str, str, str, bool]]: ...

class Controls:
    following: bool
    clutch: bool
    paused: bool
    stiffness_scale: float
    damping_scale: float
    p_hand_offset_W: Array
    def __init__(self) -> None: ...

class RealTimeOptions:
    allow_priority: bool
    allow_affinity: bool
    priority: int
    spin_us: float
    def __init__(self) -> None: ...

class BareLoop:
    def __init__(self, rate: float, options: RealTimeOptions = ...) -> None: ...
    def start(self) -> None: ...
    def stop(self) -> None: ...
    def timing(self) -> dict[str, Any]: ...

# ---- mapping

class MappingOptions:
    scale: float
    force_scale: float
    align_rate: float
    gripper_min: float
    gripper_max: float
    jaw_min: float
    jaw_max: float
    jaw_rate: float
    def __init__(self) -> None: ...

class Mapping:
    def __init__(self, options: MappingOptions, R_WL: Array, dt: float) -> None: ...
    def step(
        self,
        X_WH: Array,
        v_LH: Array,
        gripper: float,
        X_WT: Array,
        jaw: float = 0.0,
        following: bool = True,
        clutch: bool = False,
        reached: bool = True,
    ) -> tuple[Array, float, Array, bool]: ...
    def force_on_hand(self, F_T_W: Array) -> Array: ...
    def hand_position(self, p_WT: Array) -> Array: ...
    @property
    def anchorings(self) -> int: ...

# ---- force

def force(
    K: Array,
    B: Array,
    normal: Array,
    delta_x: Array,
    v_WT: Array,
    v_surface: Array,
    stiffness_scale: float = 1.0,
    damping_scale: float = 1.0,
) -> tuple[Array, Array, Array]: ...

# ---- stability

class StabilityOptions:
    force_cap: float
    rate_cap: float
    stale_after: float
    def __init__(self) -> None: ...

class Limiter:
    def __init__(self, options: StabilityOptions, dt: float) -> None: ...
    def step(
        self,
        F_H_L: Array,
        t: float = 0.0,
        t_leader: float = 0.0,
        t_follower: float = 0.0,
        leader_valid: bool = True,
        follower_valid: bool = True,
        engaged: bool = True,
    ) -> tuple[Array, Array, int]: ...

class Ledger:
    def __init__(self) -> None: ...
    def step(
        self, p_LH: Array, F_H_L: Array, F_damping: Array, F_cut: Array, spring: float
    ) -> tuple[float, float, float, float]: ...
