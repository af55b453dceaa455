# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
The simulated dVRK (simulators/dvrk), a device that does not depend on the haptic cycle.
"""

from collections.abc import Sequence
from typing import Annotated, Any, Final

import numpy
import numpy.typing
from numpy.typing import NDArray

import palpate._core


class ArmSpec:
    """
    Options of one arm of the simulated dVRK (palpate.simulators.dvrk.arm fills them).
    """

    def __init__(self, name: str, kind: str, model: palpate._core.Arm) -> None:
        """kind: 'mtm', 'psm' or 'ecm'; otherwise raises ValueError."""

    @property
    def name(self) -> str:
        """Name of the arm, such as MTMR."""

    @property
    def dynamic(self) -> bool:
        """
        True: torques move the joints; False: position servos move them, and torques do not.
        """

    @dynamic.setter
    def dynamic(self, arg: bool, /) -> None: ...

    @property
    def leader(self) -> palpate._core.LeaderOptions:
        """Drives, friction and encoders of a dynamic arm."""

    @leader.setter
    def leader(self, arg: palpate._core.LeaderOptions, /) -> None: ...

    @property
    def follower(self) -> palpate._core.FollowerOptions:
        """Joint servos of an arm that is not dynamic."""

    @follower.setter
    def follower(self, arg: palpate._core.FollowerOptions, /) -> None: ...

    @property
    def hand(self) -> palpate._core.HandOptions:
        """Impedance of the hand that holds an MTM."""

    @hand.setter
    def hand(self, arg: palpate._core.HandOptions, /) -> None: ...

    @property
    def has_gravity_model(self) -> bool:
        """True: use_gravity_compensation has an effect."""

    @has_gravity_model.setter
    def has_gravity_model(self, arg: bool, /) -> None: ...

    @property
    def platform_gain(self) -> float:
        """Gain of the platform control on joint 4 of an MTM, 0..1 [-]."""

    @platform_gain.setter
    def platform_gain(self, arg: float, /) -> None: ...

    @property
    def base_frame(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose (4, 4) of the arm's own base in the frame of measured_cp."""

    @base_frame.setter
    def base_frame(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def cannula_link(self) -> int:
        """
        Index of the link that must be past the cannula for Cartesian control; -1: no check.
        """

    @cannula_link.setter
    def cannula_link(self, arg: int, /) -> None: ...

    @property
    def jaw_min(self) -> float:
        """Smallest angle of the jaw [rad]."""

    @jaw_min.setter
    def jaw_min(self, arg: float, /) -> None: ...

    @property
    def jaw_max(self) -> float:
        """Largest angle of the jaw [rad]."""

    @jaw_max.setter
    def jaw_max(self, arg: float, /) -> None: ...

    @property
    def jaw_v_max(self) -> float:
        """Speed limit of the jaw [rad/s]."""

    @jaw_v_max.setter
    def jaw_v_max(self, arg: float, /) -> None: ...

    @property
    def jaw_a_max(self) -> float:
        """Acceleration limit of the jaw [rad/s^2]."""

    @jaw_a_max.setter
    def jaw_a_max(self, arg: float, /) -> None: ...

    @property
    def tool_type(self) -> str:
        """Tool mounted at power-up; empty: no tool."""

    @tool_type.setter
    def tool_type(self, arg: str, /) -> None: ...

    @property
    def power_time(self) -> float:
        """Time from enable to powered [s]."""

    @power_time.setter
    def power_time(self, arg: float, /) -> None: ...

    @property
    def bias_time(self) -> float:
        """Time to bias the encoders from the potentiometers [s]."""

    @bias_time.setter
    def bias_time(self, arg: float, /) -> None: ...

    @property
    def P(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Proportional gains (n,) of position control [N m/rad, N/m]."""

    @P.setter
    def P(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def D(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Derivative gains (n,) of position control [N m s/rad, N s/m]."""

    @D.setter
    def D(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def tracking_error(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Position error (n,) beyond which an arm faults [rad, m]."""

    @tracking_error.setter
    def tracking_error(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def v_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Speed limits (n,) of trajectories [rad/s, m/s]."""

    @v_max.setter
    def v_max(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def a_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Acceleration limits (n,) of trajectories [rad/s^2, m/s^2]."""

    @a_max.setter
    def a_max(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Joint positions (n,) at power-up [rad, m]."""

    @start.setter
    def start(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def home(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Joint positions (n,) after homing [rad, m]."""

    @home.setter
    def home(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class TeleopSpec:
    """
    A teleoperation of a PSM by an MTM; both are indices into the list of arms.
    """

    def __init__(self) -> None: ...

    @property
    def mtm(self) -> int:
        """Index of the MTM."""

    @mtm.setter
    def mtm(self, arg: int, /) -> None: ...

    @property
    def psm(self) -> int:
        """Index of the PSM."""

    @psm.setter
    def psm(self, arg: int, /) -> None: ...

    @property
    def scale(self) -> float:
        """Motion scale [-]."""

    @scale.setter
    def scale(self, arg: float, /) -> None: ...

    @property
    def align_MTM(self) -> bool:
        """True: the MTM aligns its orientation with the PSM."""

    @align_MTM.setter
    def align_MTM(self, arg: bool, /) -> None: ...

    @property
    def rotation_locked(self) -> bool:
        """True: the PSM keeps its orientation."""

    @rotation_locked.setter
    def rotation_locked(self, arg: bool, /) -> None: ...

    @property
    def translation_locked(self) -> bool:
        """True: the PSM keeps its position."""

    @translation_locked.setter
    def translation_locked(self, arg: bool, /) -> None: ...

    @property
    def orientation_tolerance(self) -> float:
        """Largest orientation error at which following may start [rad]."""

    @orientation_tolerance.setter
    def orientation_tolerance(self, arg: float, /) -> None: ...

    @property
    def gripper_threshold(self) -> float:
        """Range of gripper motion that shows that the operator is ready [rad]."""

    @gripper_threshold.setter
    def gripper_threshold(self, arg: float, /) -> None: ...

    @property
    def roll_threshold(self) -> float:
        """Range of roll motion that shows that the operator is ready [rad]."""

    @roll_threshold.setter
    def roll_threshold(self, arg: float, /) -> None: ...

    @property
    def jaw_rate(self) -> float:
        """Rate at which the jaw follows the gripper [rad/s]."""

    @jaw_rate.setter
    def jaw_rate(self, arg: float, /) -> None: ...

    @property
    def jaw_rate_after_clutch(self) -> float:
        """
        Rate at which the jaw follows the gripper after the clutch, until it has caught up [rad/s].
        """

    @jaw_rate_after_clutch.setter
    def jaw_rate_after_clutch(self, arg: float, /) -> None: ...

class System:
    """A simulated dVRK; palpate.simulators.dvrk.system() makes one."""

    def __init__(
        self,
        arms: Sequence[ArmSpec],
        teleops: Sequence[TeleopSpec],
        camera: Sequence[int] = [],
        head_sensor: bool = False,
    ) -> None:
        """
        camera: indices of MTML, MTMR and ECM that the camera pedal couples; empty: none. head_sensor: the operator's
        presence comes from a head sensor, not from the coag pedal.
        """

    @property
    def arms(self) -> list[str]:
        """Names of the arms, such as MTMR."""

    @property
    def teleops(self) -> list[str]:
        """Names of the teleoperations, such as MTMR_PSM1."""

    @property
    def t(self) -> float:
        """Time since the simulation began [s]."""

    tick: Final[float] = ...
    """Period of the simulation [s]."""

    @property
    def dropped_events(self) -> int:
        """Number of events lost because events() was not called in time."""

    def step(self, n: int = 1) -> None:
        """Simulates n ticks of 1/3 ms."""

    def send(self, component: str, verb: str, value: object | None = None, velocity: object | None = None) -> bool:
        """
        Sends a command by the name of its topic. Its payload decides the type of value: bool, float, str, int (button),
        joints (n,), pose (4,4), rotation (3,3), wrench (6,), or a dict: {pose, twist, wrench}, or the gains of
        servo_ci.
        """

    def events(self) -> list[tuple[float, str, str, Any]]:
        """
        Takes all events since the last call: [(t, component, topic, value), ..].
        """

    def state(self, arm: str) -> dict[str, Any]:
        """Last published state of an arm, by the names of its topics."""

    def truth(self, arm: str) -> dict[str, Any]:
        """
        True joint positions and velocities of a simulated arm and the torques of its drives, for tests and studies.
        """

    def teleop(self, name: str) -> dict[str, Any]:
        """Last published state of a teleoperation."""

    def forward_kinematics(
        self,
        arm: str,
        q: numpy.typing.ArrayLike,
    ) -> Annotated[NDArray[numpy.float64], "(4, 4)"] | None:
        """
        Pose (4, 4) of the tip in the arm's base frame; None if q has the wrong length.
        """

    def inverse_kinematics(
        self,
        arm: str,
        X: object,
        q: numpy.typing.ArrayLike,
    ) -> Annotated[NDArray[numpy.float64], "(:,)"] | None:
        """
        Joint positions (n,) that place the tip at X, searched from q; None: out of reach.
        """

    def joint_position(
        self,
        arm: str,
        actuators: numpy.typing.ArrayLike,
    ) -> Annotated[NDArray[numpy.float64], "(:,)"] | None:
        """
        Joint positions for actuator positions, including the jaw of a PSM; None if the length is wrong.
        """

def verbs() -> list[tuple[int, int, str, int]]:
    """
    All commands: (kind of component, kinds of arms as bits, name, payload).
    """

def topics() -> list[tuple[int, int, str, int, bool]]:
    """
    All events: (kind of component, kinds of arms as bits, name, payload, latched).
    """

def impedance_wrench(
    gains: dict[str, Any],
    X: Annotated[NDArray[numpy.float64], "(4, 4)"],
    V: Annotated[NDArray[numpy.float64], "(6,)"],
) -> Annotated[NDArray[numpy.float64], "(6,)"]:
    """
    Wrench (6,) that servo_ci applies at pose X moving with twist V, in the base frame.
    """

class Trajectory:
    """Point-to-point motion of joints that start and come to rest together."""

    def __init__(self) -> None: ...

    def start(
        self,
        q: Annotated[NDArray[numpy.float64], "(:,)"],
        v: Annotated[NDArray[numpy.float64], "(:,)"],
        goal: Annotated[NDArray[numpy.float64], "(:,)"],
        v_max: Annotated[NDArray[numpy.float64], "(:,)"],
        a_max: Annotated[NDArray[numpy.float64], "(:,)"],
    ) -> None:
        """
        Plans from (q, v) to rest at goal within v_max and a_max; all (n,) [rad, m, s].
        """

    def step(self, dt: float) -> None:
        """Advances by dt [s]."""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Joint positions (n,) [rad, m]."""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Joint velocities (n,) [rad/s, m/s]."""

    @property
    def done(self) -> bool:
        """True once the joints rest at the goal."""

    @property
    def duration(self) -> float:
        """Duration of the whole motion [s]."""
