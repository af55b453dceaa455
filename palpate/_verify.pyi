# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
Independent checks of the core, and single stages and clocks for studies, benchmarks and tests.
"""

from collections.abc import Sequence
from typing import Annotated

import numpy
import numpy.typing
from numpy.typing import NDArray

import palpate._core
import palpate._guidance
import palpate._tissue


class SwingJudgement:
    """Whether a motion keeps oscillating."""

    @property
    def swing(self) -> str:
        """rests, decays, lasts or undecided."""

    @property
    def growth(self) -> float:
        """Relative growth rate of the amplitude, from its trend [1/s]."""

    @property
    def change(self) -> float:
        """Change of the logarithm of the amplitude over all windows [-]."""

    @property
    def period(self) -> float:
        """Period of the slowest mode, as given or as observed [s]."""

def judge_swing(x: Sequence[float], dt: float, period: float, floor: float) -> SwingJudgement:
    """
    Judges positions x (n,) [m] at intervals dt [s]: whether the end stays within floor [m], and whether the amplitude
    of windows of at least one period [s] of the slowest mode falls along its trend.
    """

AXIS_QUANTA: float = 8.0

AXIS_UNFELT: float = 1e-06

class AxisOptions:
    """
    One axis of a haptic device with its control loop, a hand, and a virtual wall at x > 0.
    """

    def __init__(self) -> None: ...

    @property
    def mass(self) -> float:
        """Mass of the device [kg]."""

    @mass.setter
    def mass(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """Viscous damping of the device [N s/m]."""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

    @property
    def coulomb(self) -> float:
        """Dry friction of the device [N]."""

    @coulomb.setter
    def coulomb(self, arg: float, /) -> None: ...

    @property
    def rate(self) -> float:
        """Rate of the haptic cycle [Hz]."""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def delay(self) -> float:
        """Delay from the measurement to the force [s]."""

    @delay.setter
    def delay(self, arg: float, /) -> None: ...

    @property
    def jitter(self) -> float:
        """Additional random delay of each cycle, uniform in 0..jitter [s]."""

    @jitter.setter
    def jitter(self, arg: float, /) -> None: ...

    @property
    def quantum(self) -> float:
        """Resolution of the measured position [m]; 0: exact."""

    @quantum.setter
    def quantum(self, arg: float, /) -> None: ...

    @property
    def velocity_cutoff(self) -> float:
        """
        Cutoff of the low-pass on the differentiated position [Hz]; 0: no low-pass.
        """

    @velocity_cutoff.setter
    def velocity_cutoff(self, arg: float, /) -> None: ...

    @property
    def K(self) -> float:
        """Stiffness of the wall [N/m]."""

    @K.setter
    def K(self, arg: float, /) -> None: ...

    @property
    def B(self) -> float:
        """Damping of the wall [N s/m]."""

    @B.setter
    def B(self, arg: float, /) -> None: ...

    @property
    def bilateral(self) -> bool:
        """True: the wall is a spring that also pulls."""

    @bilateral.setter
    def bilateral(self, arg: bool, /) -> None: ...

    @property
    def force_max(self) -> float:
        """Largest force of the device [N]."""

    @force_max.setter
    def force_max(self, arg: float, /) -> None: ...

    @property
    def rate_max(self) -> float:
        """Largest rate of change of the force [N/s]."""

    @rate_max.setter
    def rate_max(self, arg: float, /) -> None: ...

    @property
    def hand_mass(self) -> float:
        """Mass of the hand, which moves with the device [kg]."""

    @hand_mass.setter
    def hand_mass(self, arg: float, /) -> None: ...

    @property
    def hand_damping(self) -> float:
        """Damping between the hand and its intended path [N s/m]."""

    @hand_damping.setter
    def hand_damping(self, arg: float, /) -> None: ...

    @property
    def hand_stiffness(self) -> float:
        """Stiffness between the hand and its intended path [N/m]."""

    @hand_stiffness.setter
    def hand_stiffness(self, arg: float, /) -> None: ...

    @property
    def seed(self) -> int:
        """Seed of the jitter."""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

class AxisResult:
    """Outcome of a run of an Axis."""

    @property
    def diverged(self) -> bool:
        """True if |x| reached 1 m."""

    @property
    def oscillates(self) -> bool:
        """True if |x| reached 1 m, or if the swing lasts."""

    @property
    def swing(self) -> str:
        """rests, decays, lasts or undecided (judge_swing)."""

    @property
    def growth(self) -> float:
        """Relative growth rate of the amplitude, from its trend [1/s]."""

    @property
    def duration(self) -> float:
        """Duration of the run [s]."""

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak motion in the last quarter of the run [m]."""

    @property
    def frequency(self) -> float:
        """Frequency of the motion in the last quarter of the run [Hz]."""

    @property
    def peak(self) -> float:
        """Largest penetration [m]."""

    @property
    def rest(self) -> float:
        """Mean position in the last quarter of the run [m]."""

    @property
    def overshoot(self) -> float:
        """(peak - rest) / rest [-]; 0 if the axis does not rest inside the wall."""

    @property
    def settling(self) -> float:
        """Time from which on |x - rest| < 2 % of |rest| [s]."""

    @property
    def energy_port(self) -> float:
        """Energy that the wall took from the hand, by the true positions [J]."""

    @property
    def energy_min(self) -> float:
        """
        Smallest value of that energy; negative if the wall generated energy [J].
        """

class Axis:
    """
    Simulates the axis in closed form between commands, cycles and reversals of the dry friction.
    """

    def __init__(self, options: AxisOptions) -> None: ...

    def run(
        self,
        duration: float | None = None,
        x0: float = 0.0,
        v0: float = 0.0,
        push: float = 0.0,
        path: Sequence[float] = [],
        stability: palpate._core.StabilityOptions | None = None,
    ) -> AxisResult:
        """
        Simulates duration [s] from position x0 [m] and velocity v0 [m/s]. Without a duration the run is as long as the
        judgement of the swing needs, in periods of the slowest mode. push: constant force of the hand [N]. path:
        intended position of the hand at each cycle [m], its last value held; empty: 0. stability: options of the stage
        `stability`; None: without that stage.
        """

    def trace(
        self,
        duration: float | None = None,
        x0: float = 0.0,
        v0: float = 0.0,
        push: float = 0.0,
        path: Sequence[float] = [],
        stability: palpate._core.StabilityOptions | None = None,
    ) -> tuple[AxisResult, Annotated[NDArray[numpy.float64], "(:, :)"]]:
        """
        The same run as (AxisResult, rows (n, 5)) with one row per cycle: t [s], x [m], v [m/s], force commanded on the
        device along x [N], energy_port [J].
        """

def touched(
    scenes: Sequence[palpate._core.Snapshot],
    scene: Annotated[NDArray[numpy.int32], "(:,)"],
    centres: Annotated[NDArray[numpy.float64], "(:, :, 3)"],
    resets: Annotated[NDArray[numpy.int32], "(:,)"],
    method: str,
    options: palpate._core.ContactOptions,
    rate: float = 1000.0,
) -> NDArray[numpy.float64]:
    """
    Depth (n, spheres, objects) of each contact of a tool [m], 0 without, in n ticks. centres: of its spheres in W (n,
    spheres, 3) [m]; scene: (n,) number of the snapshot in each tick, which is handed over as to a loop where it
    changes; resets: (n,) not 0 where the tool is reset before the tick.
    """

class SoakRange:
    """Ranges from which each pass draws its values."""

    def __init__(self) -> None: ...

    @property
    def radius_min(self) -> float:
        """Smallest SPR radius [m]."""

    @radius_min.setter
    def radius_min(self, arg: float, /) -> None: ...

    @property
    def radius_max(self) -> float:
        """Largest SPR radius [m]."""

    @radius_max.setter
    def radius_max(self, arg: float, /) -> None: ...

    @property
    def speed_min(self) -> float:
        """Smallest speed of the tool [m/s]."""

    @speed_min.setter
    def speed_min(self, arg: float, /) -> None: ...

    @property
    def speed_max(self) -> float:
        """Largest speed of the tool [m/s]."""

    @speed_max.setter
    def speed_max(self, arg: float, /) -> None: ...

    @property
    def depth(self) -> float:
        """Largest depth below the surface [m]."""

    @depth.setter
    def depth(self, arg: float, /) -> None: ...

    @property
    def drag(self) -> float:
        """Largest length of the drag that follows, in any direction [m]."""

    @drag.setter
    def drag(self, arg: float, /) -> None: ...

    @property
    def angle(self) -> float:
        """Largest angle between the motion and the surface normal [rad]."""

    @angle.setter
    def angle(self, arg: float, /) -> None: ...

    @property
    def object_speed(self) -> float:
        """Largest speed of the object [m/s]."""

    @object_speed.setter
    def object_speed(self, arg: float, /) -> None: ...

class SoakPass:
    """Values of one pass."""

    @property
    def index(self) -> int:
        """Index of the pass; -1: no pass."""

    @property
    def radius(self) -> float:
        """SPR radius [m]."""

    @property
    def speed(self) -> float:
        """Speed of the tool [m/s]."""

    @property
    def depth(self) -> float:
        """Depth below the surface [m]."""

    @property
    def object_moves(self) -> bool:
        """True if the object moves."""

class SoakReport:
    """Outcome of many passes at one mesh."""

    @property
    def passes(self) -> int:
        """Number of passes that found free space to begin in."""

    @property
    def ticks(self) -> int:
        """Number of ticks."""

    @property
    def touched(self) -> int:
        """Number of passes with a contact force."""

    @property
    def popped(self) -> int:
        """Number of passes whose proxy crossed the surface."""

    @property
    def first_popped(self) -> SoakPass:
        """First pass whose proxy crossed the surface."""

def soak(mesh: palpate._core.Mesh, method: str, passes: int, seed: int, range: SoakRange) -> SoakReport:
    """
    Simulates random pokes at a mesh at 1 kHz and tests the proxy against each triangle. It releases the interpreter
    lock.
    """

class TissueSoakRange:
    """Ranges from which each action draws its values."""

    def __init__(self) -> None: ...

    @property
    def radius(self) -> float:
        """Radius of both spheres [m]."""

    @radius.setter
    def radius(self, arg: float, /) -> None: ...

    @property
    def speed_min(self) -> float:
        """Smallest speed [m/s]."""

    @speed_min.setter
    def speed_min(self, arg: float, /) -> None: ...

    @property
    def speed_max(self) -> float:
        """Largest speed, that of slides [m/s]."""

    @speed_max.setter
    def speed_max(self, arg: float, /) -> None: ...

    @property
    def depth(self) -> float:
        """Longest way below the surface [m]."""

    @depth.setter
    def depth(self, arg: float, /) -> None: ...

    @property
    def force_min(self) -> float:
        """Smallest force at which the tool turns back [N]."""

    @force_min.setter
    def force_min(self, arg: float, /) -> None: ...

    @property
    def force_max(self) -> float:
        """Largest force at which it turns back [N]."""

    @force_max.setter
    def force_max(self, arg: float, /) -> None: ...

    @property
    def hard_share(self) -> float:
        """Share of the actions beyond force_max [-]."""

    @hard_share.setter
    def hard_share(self, arg: float, /) -> None: ...

    @property
    def hard_force(self) -> float:
        """Force at which those turn back [N]."""

    @hard_force.setter
    def hard_force(self, arg: float, /) -> None: ...

    @property
    def friction(self) -> float:
        """Largest coefficient of friction [-]."""

    @friction.setter
    def friction(self, arg: float, /) -> None: ...

    @property
    def rest_every(self) -> int:
        """Actions between two checks at rest."""

    @rest_every.setter
    def rest_every(self, arg: int, /) -> None: ...

    @property
    def rest(self) -> float:
        """Time without contact before a check [s]."""

    @rest.setter
    def rest(self, arg: float, /) -> None: ...

    @property
    def hold(self) -> float:
        """Time for which a poke is held where it turns back [s]."""

    @hold.setter
    def hold(self, arg: float, /) -> None: ...

    @property
    def restless(self) -> float:
        """Second difference of the force that is no rest [N]."""

    @restless.setter
    def restless(self, arg: float, /) -> None: ...

    @property
    def decay(self) -> float:
        """
        Kinetic energy over that of the third of the hold before, below which a swing decays [-].
        """

    @decay.setter
    def decay(self, arg: float, /) -> None: ...

class TissueSoakReport:
    """Outcome of many actions at one soft body."""

    @property
    def pokes(self) -> int:
        """Number of pokes."""

    @property
    def slides(self) -> int:
        """Number of slides."""

    @property
    def grasps(self) -> int:
        """Number of grasps."""

    @property
    def hard(self) -> int:
        """Number of actions beyond force_max."""

    @property
    def touched(self) -> int:
        """Number of actions with a contact."""

    @property
    def ticks(self) -> int:
        """Number of ticks."""

    @property
    def held(self) -> int:
        """Pokes that were held in contact."""

    @property
    def restless(self) -> int:
        """Of these, up to force_max, with a force that did not come to rest."""

    @property
    def not_finite(self) -> int:
        """Actions with a force that is not finite."""

    @property
    def popped(self) -> int:
        """Actions in which a sphere lost its contact below the surface."""

    @property
    def guarded(self) -> int:
        """Actions up to force_max in which the guard stopped a divergence."""

    @property
    def guarded_hard(self) -> int:
        """The same, of the hard actions."""

    @property
    def hurried(self) -> int:
        """Actions in which the body took more steps."""

    @property
    def rests(self) -> int:
        """Checks at rest."""

    @property
    def inverted_at_rest(self) -> int:
        """Checks with an inverted tetrahedron."""

    @property
    def moved_at_rest(self) -> int:
        """Checks with a displaced node."""

    @property
    def least_volume(self) -> float:
        """Smallest det F in an action [-]."""

    @property
    def least_volume_at_rest(self) -> float:
        """Smallest det F at rest [-]."""

    @property
    def largest_force(self) -> float:
        """Largest force of the actions up to force_max [N]."""

def soak_tissue(
    surface: palpate._tissue.TissueSurface,
    actions: int,
    seed: int,
    held_below: float,
    range: TissueSoakRange,
) -> TissueSoakReport:
    """
    Pokes, slides and grasps a copy at rest of a soft surface at random, at 1 kHz, above the height held_below [m]. It
    releases the interpreter lock.
    """

class StabilityOutput:
    """
    Output of one tick of the stage; wrenches (6,) on the hand in L [N, N m].
    """

    @property
    def F_H_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Wrench to be rendered (6,)."""

    @property
    def F_capped(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Output of the limiter, input of the passivity controller (6,)."""

    @property
    def F_coupling(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Input minus output of the virtual coupling (6,)."""

    @property
    def F_low_pass(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Input minus output of the low-pass (6,)."""

    @property
    def F_passivity(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Input minus output of the passivity controller (6,)."""

    @property
    def lag(self) -> list[float]:
        """
        Lags of the coupling, the low-pass, the passivity controller and the caps [s].
        """

    @property
    def status(self) -> int:
        """Status bits."""

class Stability:
    """Stage `stability`: coupling, low-pass, passivity controller, limiter."""

    def __init__(self, options: palpate._core.StabilityOptions, dt: float) -> None:
        """dt: period of the cycle [s]."""

    def step(
        self,
        F_H_L: numpy.typing.ArrayLike,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        q: Annotated[NDArray[numpy.float64], "(:,)"] = ...,
        stiffness: float = 0.0,
        t: float = 0.0,
        t_leader: float = 0.0,
        engaged: bool = True,
        R_LH: Annotated[NDArray[numpy.float64], "(3, 3)"] = ...,
        w_LH: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        potential: float = float('inf'),
        dt: float = 0.0,
        credit: float = 0.0,
    ) -> StabilityOutput:
        """
        One tick at t [s] with the handle at p_LH (3,) [m], R_LH (3, 3), v_LH (3,) [m/s], w_LH (3,) [rad/s], joints q
        (n,), and the wrench F_H_L (6,) to be rendered. potential: energy that its springs store now [J]; infinity:
        unknown. dt: time since the last tick, 0: one period [s]; credit: energy of potentials that were switched on
        [J]. Call rendered() after each step.
        """

    def rendered(self, F_H_L: numpy.typing.ArrayLike) -> None:
        """
        Reports the wrench (6,) that the drives rendered after their torque limits.
        """

    @property
    def stored(self) -> float:
        """Energy that may be returned to the hand [J]."""

    @property
    def credited(self) -> float:
        """Energy credited and not yet repaid [J]."""

    @property
    def reserve(self) -> float:
        """
        Energy that the account may hold beyond the potential, in mode 'observer' [J].
        """

    @property
    def reserved(self) -> float:
        """Part of `stored` that is reserved for wrenches still in the delay [J]."""

class Limiter:
    """
    Caps and watchdog of the stage `stability`: its output is finite and within the cap and the rate cap.
    """

    def __init__(self, options: palpate._core.StabilityOptions, dt: float) -> None:
        """dt: period of the cycle [s]."""

    def step(
        self,
        F_H_L: numpy.typing.ArrayLike,
        t: float = 0.0,
        t_leader: float = 0.0,
        t_follower: float = 0.0,
        leader_valid: bool = True,
        follower_valid: bool = True,
        engaged: bool = True,
        explained: float = 0.0,
        dt: float = 0.0,
        potential: float = float('inf'),
        work: float = 0.0,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(:,)"], int]:
        """
        One tick with a force (3,) or a wrench (6,): (F_H_L to be rendered, F_cut = input - output, status bits).
        explained: fall of the force that the motion explains [N]; dt: time since the last tick, 0: one period [s];
        potential: energy of the springs behind the wrench, infinity: unknown [J]; work: of the hand since the last tick
        [J].
        """

class Energy:
    """Entries of the energy ledger, at the hand's port [J]."""

    @property
    def port(self) -> float:
        """
        Energy that the rendered force took from the hand; negative: generated energy.
        """

    @property
    def spring(self) -> float:
        """Energy stored in the contacts' springs."""

    @property
    def damping(self) -> float:
        """Energy dissipated by the damping forces."""

    @property
    def cut(self) -> float:
        """Energy of the force that the caps removed."""

    @property
    def passivity(self) -> float:
        """Energy of the force that the passivity controller removed."""

    @property
    def source(self) -> list[float]:
        """Energy of the force of each source."""

class Ledger:
    """
    Energy ledger at the hand's port: the work of each force on the motion during which it acts.
    """

    def __init__(self, delay: float = 0.0, dt: float = 0.001) -> None:
        """delay: known delay of the loop [s]; dt: period of the cycle [s]."""

    def step(
        self,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        F_H_L: numpy.typing.ArrayLike,
        F_damping: numpy.typing.ArrayLike,
        F_cut: numpy.typing.ArrayLike,
        spring: float,
        R_LH: Annotated[NDArray[numpy.float64], "(3, 3)"] = ...,
        F_source: Annotated[NDArray[numpy.float64], "(:, :)"] | None = None,
    ) -> Energy:
        """
        One tick with the handle at p_LH (3,) [m] and R_LH (3, 3). Forces (3,) or wrenches (6,) in L; F_source: one row
        for each source; spring: stored energy [J]. Returns the energies since the start [J].
        """

class PassivityObserver:
    """
    Certified energy that the hand has put into the port, for a force at one point.
    """

    def __init__(self, options: palpate._core.StabilityOptions, dt: float) -> None:
        """dt: nominal period of the cycle [s]."""

    def step(
        self,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        F_H_L: Annotated[NDArray[numpy.float64], "(3,)"],
        dt: float = 0.001,
    ) -> float:
        """
        One tick, dt after the last one [s], with the handle at p_LH (3,) [m], v_LH (3,) [m/s]; F_H_L (3,) [N] is sent
        at its end. Returns the energy that may be returned to the hand [J].
        """

    @property
    def in_flight(self) -> float:
        """
        Largest energy that the forces already sent can still give to the hand [J].
        """

class Dissipation:
    """Certified energy that a device dissipates by friction."""

    def __init__(self, friction: palpate._core.CertainFriction, dt: float) -> None:
        """dt: period of the cycle [s]."""

    def step(self, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> float:
        """
        Certified dissipation since the last tick [J], from the measured joint positions q (n,).
        """

def held_cost(F: float, u: float, a: float, begin: float, end: float) -> float:
    """
    Largest work of a constant force: F times the integral of max(0, u + a t) over [begin, end] [J]. F [N], u [m/s], a
    [m/s^2], times [s].
    """

def fade_cost(F: float, u: float, a: float, begin: float, span: float) -> float:
    """
    Largest work of a force that falls linearly from F at `begin` to zero within `span` [s]: the integral of the force
    times max(0, u + a t) [J].
    """

FADE: float = 0.004

def time_query(
    geometry: palpate._guidance.Geometry,
    X_WT: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
) -> Annotated[NDArray[numpy.float64], "(:,)"]:
    """Durations of n queries at the poses X_WT (n, 4, 4): (n,) [us]."""

def time_guidance(
    fixtures: palpate._guidance.Fixtures,
    X_WT: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
    dt: float = 0.001,
) -> Annotated[NDArray[numpy.float64], "(:,)"]:
    """
    Durations of n ticks of guidance while the commanded tool pose follows X_WT (n, 4, 4): (n,) [us].
    """

def time_qp(
    A: Annotated[NDArray[numpy.float64], "(:, :, 6)"],
    b: Annotated[NDArray[numpy.float64], "(:, :)"],
    y0: Annotated[NDArray[numpy.float64], "(:, :)"],
) -> Annotated[NDArray[numpy.float64], "(:,)"]:
    """
    Durations of n quadratic programs of m rows, filling included: (n,) [us]. A (n, m, 6), b (n, m), y0 (n, 6).
    """
