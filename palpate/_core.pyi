# What the compiled core offers to Python. Poses are (4, 4), vectors (3,), joint vectors (n,), all float64, SI units.
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

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

# ---- arm

class IkOptions:
    max_iterations: int
    position_tolerance: float
    orientation_tolerance: float
    damping: float
    def __init__(self) -> None: ...

class IkResult:
    @property
    def converged(self) -> bool: ...
    @property
    def iterations(self) -> int: ...
    @property
    def position_error(self) -> float: ...
    @property
    def orientation_error(self) -> float: ...
    @property
    def damping(self) -> float: ...

class Arm:
    def __init__(self, xml: str, base_frame: str, tip_frame: str) -> None: ...
    @property
    def n(self) -> int: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def link_names(self) -> list[str]: ...
    @property
    def q_min(self) -> Array: ...
    @property
    def q_max(self) -> Array: ...
    @property
    def tau_max(self) -> Array: ...
    @property
    def v_max(self) -> Array: ...
    def fk(self, q: Array) -> Array: ...
    def jacobian(self, q: Array) -> Array: ...
    def gravity(self, q: Array) -> Array: ...
    def bias(self, q: Array, v: Array) -> Array: ...
    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array: ...
    def mass_matrix(self, q: Array) -> Array: ...
    def tip_drift(self, q: Array, v: Array) -> Array: ...
    def potential_energy(self, q: Array) -> float: ...
    def set_gravity(self, g_base: Array) -> None: ...
    def with_scaled_masses(self, scale: Array) -> Arm: ...
    def ik_from(self, X_0T: Array, q0: Array, options: IkOptions = ...) -> tuple[Array, IkResult]: ...
    def link_poses_array(self, q: Array) -> list[Array]: ...

# ---- plant

class HandOptions:
    mass: float
    damping: float
    stiffness: float
    inertia: float
    rotational_damping: float
    rotational_stiffness: float
    grip_force_max: float
    def __init__(self) -> None: ...

class LeaderOptions:
    coupling: Array
    encoder_step: Array
    coulomb: Array
    viscous: Array
    rotor_inertia: Array
    tau_max: Array
    loop_delay: float
    hold_timeout: float
    quantised: bool
    def __init__(self) -> None: ...

class FollowerOptions:
    bandwidth: float
    damping_ratio: float
    v_max: Array
    encoder_step: Array
    jaw_v_max: float
    def __init__(self) -> None: ...

# ---- torque

class TorqueOptions:
    mode: str
    gravity_gain: float
    platform_gain: float
    def __init__(self) -> None: ...
# ---- scene

class MeshReport:
    @property
    def vertices(self) -> int: ...
    @property
    def triangles(self) -> int: ...
    @property
    def degenerate(self) -> int: ...
    @property
    def duplicate(self) -> int: ...
    @property
    def flat(self) -> int: ...
    @property
    def boundary_edges(self) -> int: ...
    @property
    def branching_edges(self) -> int: ...
    @property
    def inconsistent_edges(self) -> int: ...
    @property
    def closed(self) -> bool: ...
    @property
    def inverted(self) -> bool: ...
    @property
    def volume(self) -> float: ...
    @property
    def lowest(self) -> Array: ...
    @property
    def highest(self) -> Array: ...

class Mesh:
    def __init__(self, vertices: Array, triangles: NDArray[np.int32]) -> None: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def report(self) -> MeshReport: ...
    @property
    def vertices(self) -> Array: ...
    @property
    def triangles(self) -> NDArray[np.int32]: ...
    def closest(self, points: Array, max_distance: float = ...) -> tuple[Array, Array, Array, NDArray[np.int32]]: ...
    def contains(self, points: Array) -> NDArray[np.bool_]: ...
    def closest_by_kernel(self, points: Array, kernel: str) -> Array: ...
    def sweep(self, a: Array, b: Array, radius: float) -> float: ...

def bvh_has_avx2() -> bool: ...

class Material:
    K: Array
    B: Array
    mu: float
    def __init__(self, K: ArrayLike = ..., B: ArrayLike = ..., mu: float = ...) -> None: ...

class Object:
    X_WO: Array
    material: Material
    def __init__(self, name: str, mesh: Mesh, X_WO: Array = ..., material: Material = ...) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def mesh(self) -> Mesh: ...

class Snapshot:
    def __init__(self, objects: Sequence[Object]) -> None: ...
    @property
    def objects(self) -> list[Object]: ...

# ---- contact

class ContactOptions:
    radius: float
    collision_rate: float
    def __init__(self) -> None: ...

def contact_render(
    snapshot: Snapshot, tips: Array, method: str, options: ContactOptions, rate: float
) -> tuple[Array, Array, Array, Array, Array, bool]: ...
def trace_algorithm1(
    snapshot: Snapshot, p_WT: Array, v_WT: Array, radius: float, n_last: Array
) -> dict[str, Any]: ...
