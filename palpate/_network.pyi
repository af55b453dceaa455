# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
Teleoperation across a network: emulated links, packets, both ends, and simulated trials.
"""

from collections.abc import Sequence
import enum
from typing import Annotated, Any

import numpy
from numpy.typing import NDArray

import palpate._core


class GilbertElliott:
    """Loss by a Markov chain of two states, stepped at each packet."""

    def __init__(
        self,
        to_bad: float = 0.0,
        to_good: float = 1.0,
        loss_good: float = 0.0,
        loss_bad: float = 0.0,
    ) -> None: ...

    @property
    def to_bad(self) -> float:
        """Probability of the step from good to bad [-]."""

    @property
    def to_good(self) -> float:
        """Probability of the step from bad to good [-]."""

    @property
    def loss_good(self) -> float:
        """Loss in the good state [-]."""

    @property
    def loss_bad(self) -> float:
        """Loss in the bad state [-]."""

class FourStates:
    """
    Loss by a Markov chain of four states: 1 received, 2 received within a burst, 3 lost within a burst, 4 lost alone.
    p13 is the probability of the step from 1 to 3.
    """

    def __init__(
        self,
        p13: float = 0.0,
        p31: float = 1.0,
        p32: float = 0.0,
        p23: float = 1.0,
        p14: float = 0.0,
    ) -> None: ...

    @property
    def p13(self) -> float:
        """1 to 3 [-]."""

    @property
    def p31(self) -> float:
        """3 to 1 [-]."""

    @property
    def p32(self) -> float:
        """3 to 2 [-]."""

    @property
    def p23(self) -> float:
        """2 to 3 [-]."""

    @property
    def p14(self) -> float:
        """1 to 4 [-]."""

class Condition:
    """What a link does to the packets of one direction. Times in seconds."""

    def __init__(self) -> None: ...

    @property
    def delay(self) -> float:
        """Smallest delay [s]."""

    @delay.setter
    def delay(self, arg: float, /) -> None: ...

    @property
    def weights(self) -> list[float]:
        """Weights of the exponentials of the additional delay [-]."""

    @weights.setter
    def weights(self, arg: Sequence[float], /) -> None: ...

    @property
    def rates(self) -> list[float]:
        """Rates of these exponentials [1/s]."""

    @rates.setter
    def rates(self, arg: Sequence[float], /) -> None: ...

    @property
    def correlation(self) -> float:
        """
        Correlation of the additional delays of successive packets, as a Gaussian copula [-].
        """

    @correlation.setter
    def correlation(self, arg: float, /) -> None: ...

    @property
    def keep_order(self) -> bool:
        """True: no packet arrives before an earlier one."""

    @keep_order.setter
    def keep_order(self, arg: bool, /) -> None: ...

    @property
    def reorder(self) -> float:
        """Share of packets that are held back by reorder_delay [-]."""

    @reorder.setter
    def reorder(self, arg: float, /) -> None: ...

    @property
    def reorder_delay(self) -> float:
        """[s]."""

    @reorder_delay.setter
    def reorder_delay(self, arg: float, /) -> None: ...

    @property
    def duplicate(self) -> float:
        """Share of packets that arrive twice [-]."""

    @duplicate.setter
    def duplicate(self, arg: float, /) -> None: ...

    @property
    def gilbert(self) -> GilbertElliott:
        """Loss of two states."""

    @gilbert.setter
    def gilbert(self, arg: GilbertElliott, /) -> None: ...

    @property
    def four(self) -> FourStates:
        """Loss of four states."""

    @four.setter
    def four(self, arg: FourStates, /) -> None: ...

    @property
    def rate(self) -> float:
        """Rate limit [bytes/s]; 0: unlimited."""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def queue(self) -> float:
        """Longest wait for the rate limit; beyond it packets are lost [s]."""

    @queue.setter
    def queue(self, arg: float, /) -> None: ...

    @property
    def outage_every(self) -> float:
        """Mean time between random outages [s]; 0: none."""

    @outage_every.setter
    def outage_every(self, arg: float, /) -> None: ...

    @property
    def outage_min(self) -> float:
        """Shortest random outage [s]."""

    @outage_min.setter
    def outage_min(self, arg: float, /) -> None: ...

    @property
    def outage_max(self) -> float:
        """Longest random outage [s]."""

    @outage_max.setter
    def outage_max(self, arg: float, /) -> None: ...

    @property
    def outages(self) -> list[tuple[float, float]]:
        """Outages as (begin, duration) [s]."""

    @outages.setter
    def outages(self, arg: Sequence[tuple[float, float]], /) -> None: ...

    @property
    def trace(self) -> list[tuple[float, float]]:
        """
        Measured delays as (time, delay) [s]; a negative delay is a loss. They replace delay and mixture.
        """

    @trace.setter
    def trace(self, arg: Sequence[tuple[float, float]], /) -> None: ...

    def check(self) -> None:
        """Raises ValueError that names the value, unless the condition is valid."""

    def quantile(self, survival: float) -> float:
        """
        Additional delay that is exceeded with the probability `survival`, in (0, 1] [s].
        """

class Link:
    """
    One direction of an emulated link. The same seed gives the same delays and losses.
    """

    def __init__(self, condition: Condition, seed: int) -> None: ...

    def send(self, t: float, bytes: int = 256) -> list[float]:
        """
        Sends a packet at the time t [s]; returns the times at which its copies arrive, none if it is lost.
        """

    def send_all(self, t: Annotated[NDArray[numpy.float64], "(:,)"], bytes: int = 256) -> NDArray[numpy.float64]:
        """
        Arrival (n,) of the first copy of packets sent at t (n,) [s]; NaN: lost.
        """

class ModelEstimate:
    """What the site has learnt about one object."""

    def __init__(self) -> None: ...

    @property
    def object(self) -> int:
        """Index of the object; 65535: none yet."""

    @object.setter
    def object(self, arg: int, /) -> None: ...

    @property
    def shift(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Displacement from its place in the scene, in W (3,) [m]."""

    @shift.setter
    def shift(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def normal(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Of a plane: outward unit normal in W; zero: an object (3,)."""

    @normal.setter
    def normal(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def K(self) -> float:
        """Stiffness [N/m]."""

    @K.setter
    def K(self, arg: float, /) -> None: ...

    @property
    def B(self) -> float:
        """Damping along the normal [N s/m]."""

    @B.setter
    def B(self, arg: float, /) -> None: ...

    @property
    def mu(self) -> float:
        """Friction coefficient [-]."""

    @mu.setter
    def mu(self, arg: float, /) -> None: ...

    @property
    def sd_K(self) -> float:
        """Standard deviation of K [N/m]."""

    @sd_K.setter
    def sd_K(self, arg: float, /) -> None: ...

    @property
    def sd_shift(self) -> float:
        """Standard deviation of the shift along the touched normal [m]."""

    @sd_shift.setter
    def sd_shift(self, arg: float, /) -> None: ...

    @property
    def margin(self) -> float:
        """Rms of the measured force minus that of the estimate [N]."""

    @margin.setter
    def margin(self, arg: float, /) -> None: ...

class Datagram:
    """State of one end at one moment, in W (docs/network.md)."""

    def __init__(self) -> None: ...

    @property
    def t(self) -> float:
        """Clock of the sender [s]."""

    @t.setter
    def t(self, arg: float, /) -> None: ...

    @property
    def t_peer(self) -> float:
        """Clock of the receiver in its newest packet that the sender has [s]."""

    @t_peer.setter
    def t_peer(self, arg: float, /) -> None: ...

    @property
    def t_received(self) -> float:
        """Clock of the sender when that packet arrived [s]."""

    @t_received.setter
    def t_received(self, arg: float, /) -> None: ...

    @property
    def X(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose of the tool (4, 4) [m]."""

    @X.setter
    def X(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Velocity of the tool (3,) [m/s]."""

    @v.setter
    def v(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def jaw(self) -> float:
        """Jaw angle [rad]."""

    @jaw.setter
    def jaw(self, arg: float, /) -> None: ...

    @property
    def F(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Force on the hand, or of the environment on the tool (3,) [N]."""

    @F.setter
    def F(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def energy_in(self) -> float:
        """Energy that the sender's port has taken, without returns [J]."""

    @energy_in.setter
    def energy_in(self, arg: float, /) -> None: ...

    @property
    def energy_out(self) -> float:
        """Energy that it has given [J]."""

    @energy_out.setter
    def energy_out(self, arg: float, /) -> None: ...

    @property
    def play_delay(self) -> float:
        """Site: delay at which the motion is played [s]."""

    @play_delay.setter
    def play_delay(self, arg: float, /) -> None: ...

    @property
    def flags(self) -> int:
        """Bits FLAG_*."""

    @flags.setter
    def flags(self, arg: int, /) -> None: ...

    @property
    def model(self) -> ModelEstimate:
        """Site: the estimate of the object touched last."""

    @model.setter
    def model(self, arg: ModelEstimate, /) -> None: ...

PACKET_SIZE: int = 172

PACKET_VERSION: int = 2

FLAG_ENGAGED: int = 1

FLAG_OUTAGE: int = 2

FLAG_ALIGNED: int = 4

FLAG_HOLDING: int = 8

FLAG_LIMITED: int = 16

FLAG_UNMODELLED: int = 32

def encode(datagram: Datagram) -> bytes:
    """The bytes of a datagram before encryption."""

def decode(bytes: bytes) -> Datagram | None:
    """The datagram of these bytes; None unless they are valid."""

class ReplayWindow:
    """Refuses numbers that were seen before or are too old."""

    def __init__(self) -> None: ...

    def accept(self, number: int) -> bool:
        """True if the number is new; it then counts as seen."""

class ClockSync:
    """Offset and drift of the peer's clock, by the times of packets."""

    def __init__(self) -> None: ...

    def add(self, t1: float, t2: float, t3: float, t4: float) -> None:
        """
        One exchange [s]: t1 sent here, t2 received there, t3 sent there, t4 received here.
        """

    def offset(self, t: float) -> float:
        """Peer's clock minus own clock at the own time t [s]."""

    @property
    def known(self) -> bool:
        """True once an exchange is known."""

    @property
    def drift(self) -> float:
        """Rate of the peer's clock minus 1 [-]."""

    @property
    def bound(self) -> float:
        """Bound of the error by an unknown asymmetry of the delays [s]."""

class Arrivals:
    """Percentiles of the age of the newest packet, and outages."""

    def __init__(self) -> None: ...

    def step(self, age: float, dt: float) -> None:
        """One tick: age of the newest packet, time since the last tick [s]."""

    @property
    def outage(self) -> bool:
        """True during an outage."""

    @property
    def age(self) -> float:
        """Age of the newest packet [s]."""

    @property
    def p50(self) -> float:
        """Median of the age [s]."""

    @property
    def p99(self) -> float:
        """99th percentile [s]."""

    @property
    def p999(self) -> float:
        """99.9th percentile [s]."""

    @property
    def limit(self) -> float:
        """Age from which an outage is told [s]."""

    @property
    def outages(self) -> int:
        """Number of outages so far."""

class Mode(enum.Enum):
    """What crosses the network between hand and remote tool."""

    model = 0
    """Parameters of a local model."""

    passivity = 1
    """The measured force, as far as the energies of both ports allow."""

    direct = 2
    """The measured force, without any limit."""

class EstimatorOptions:
    """What the estimator assumes before the first touch."""

    def __init__(self) -> None: ...

    @property
    def K(self) -> float:
        """Assumed stiffness [N/m]."""

    @K.setter
    def K(self, arg: float, /) -> None: ...

    @property
    def sd_K(self) -> float:
        """Its standard deviation [N/m]."""

    @sd_K.setter
    def sd_K(self, arg: float, /) -> None: ...

    @property
    def sd_place(self) -> float:
        """Standard deviation of the place along each axis [m]."""

    @sd_place.setter
    def sd_place(self, arg: float, /) -> None: ...

    @property
    def sd_force(self) -> float:
        """Noise of the measured force [N]."""

    @sd_force.setter
    def sd_force(self, arg: float, /) -> None: ...

    @property
    def sd_model(self) -> float:
        """Error of the linear law, share of the force [-]."""

    @sd_model.setter
    def sd_model(self, arg: float, /) -> None: ...

    @property
    def most_shift(self) -> float:
        """Largest displacement that is believed [m]."""

    @most_shift.setter
    def most_shift(self, arg: float, /) -> None: ...

class UpdateOptions:
    """Limits of updates of the local model."""

    def __init__(self) -> None: ...

    @property
    def tank(self) -> float:
        """Energy in the tank at the start [J]."""

    @tank.setter
    def tank(self, arg: float, /) -> None: ...

    @property
    def capacity(self) -> float:
        """Most energy that the tank keeps [J]."""

    @capacity.setter
    def capacity(self, arg: float, /) -> None: ...

    @property
    def force_rate(self) -> float:
        """Largest change of the force by an update [N/s]."""

    @force_rate.setter
    def force_rate(self, arg: float, /) -> None: ...

    @property
    def speed(self) -> float:
        """Largest speed of a surface that is updated [m/s]."""

    @speed.setter
    def speed(self, arg: float, /) -> None: ...

    @property
    def least_sure(self) -> float:
        """Largest relative deviation of a stiffness taken [-]."""

    @least_sure.setter
    def least_sure(self, arg: float, /) -> None: ...

class EndOptions:
    """What both ends have alike."""

    @property
    def mode(self) -> Mode:
        """Mode."""

    @mode.setter
    def mode(self, arg: Mode, /) -> None: ...

    @property
    def radius(self) -> float:
        """Radius of the tool's sphere [m]."""

    @radius.setter
    def radius(self, arg: float, /) -> None: ...

    @property
    def planes(self) -> bool:
        """Surfaces that the scene does not have are felt as planes."""

    @planes.setter
    def planes(self, arg: bool, /) -> None: ...

    @property
    def drag(self) -> float:
        """Damping of the hand in the mode passivity [N s/m]."""

    @drag.setter
    def drag(self, arg: float, /) -> None: ...

class SiteOptions(EndOptions):
    """Options of the follower's end."""

    def __init__(self) -> None: ...

    @property
    def force_cap(self) -> float:
        """Largest force on the tissue [N]."""

    @force_cap.setter
    def force_cap(self, arg: float, /) -> None: ...

    @property
    def mass(self) -> float:
        """Of the tool [kg]."""

    @mass.setter
    def mass(self, arg: float, /) -> None: ...

    @property
    def speed(self) -> float:
        """Largest speed of the tool's goal [m/s]."""

    @speed.setter
    def speed(self, arg: float, /) -> None: ...

    @property
    def catch_up(self) -> float:
        """The same while the tool aligns [m/s]."""

    @catch_up.setter
    def catch_up(self, arg: float, /) -> None: ...

    @property
    def turn(self) -> float:
        """Largest angular speed of the goal, and of the jaw [rad/s]."""

    @turn.setter
    def turn(self, arg: float, /) -> None: ...

    @property
    def allowance(self) -> float:
        """Energy that may be spent in advance [J]."""

    @allowance.setter
    def allowance(self, arg: float, /) -> None: ...

    @property
    def estimator(self) -> EstimatorOptions:
        """Options of the estimator."""

    @estimator.setter
    def estimator(self, arg: EstimatorOptions, /) -> None: ...

class InstrumentOptions:
    """A simulated instrument."""

    def __init__(self) -> None: ...

    @property
    def mass(self) -> float:
        """[kg]."""

    @mass.setter
    def mass(self, arg: float, /) -> None: ...

    @property
    def bandwidth(self) -> float:
        """Natural frequency of its servo [Hz]."""

    @bandwidth.setter
    def bandwidth(self, arg: float, /) -> None: ...

    @property
    def drive_cap(self) -> float:
        """Largest force of its drives [N]."""

    @drive_cap.setter
    def drive_cap(self, arg: float, /) -> None: ...

    @property
    def noise(self) -> float:
        """Standard deviation of the measured force [N]."""

    @noise.setter
    def noise(self, arg: float, /) -> None: ...

    @property
    def quantum(self) -> float:
        """Resolution of the measured position [m]."""

    @quantum.setter
    def quantum(self, arg: float, /) -> None: ...

    @property
    def substeps(self) -> int:
        """Per tick."""

    @substeps.setter
    def substeps(self, arg: int, /) -> None: ...

class Estimator:
    """Place, stiffness, damping and friction of a touched object."""

    def __init__(self, options: EstimatorOptions) -> None: ...

    def step(
        self,
        depth: float,
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        v: Annotated[NDArray[numpy.float64], "(3,)"],
        F: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> None:
        """
        One tick: depth below the surface of the scene [m], outward normal (3,), velocity relative to the surface (3,)
        [m/s], measured force (3,) [N].
        """

    @property
    def estimate(self) -> ModelEstimate:
        """The estimate."""

    @property
    def moved(self) -> int:
        """Number of times that the object was found moved."""

class ModelUpdate:
    """Parameters that approach an estimate without kick and free energy."""

    def __init__(self, options: UpdateOptions, now: ModelEstimate) -> None: ...

    def step(
        self,
        goal: ModelEstimate,
        depth: float,
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        dt: float = 0.001,
        dissipated: float = 0.0,
    ) -> ModelEstimate:
        """
        One tick towards a goal with the tool at this depth [m] and outward normal (3,); the parameters to render.
        """

    @property
    def now(self) -> ModelEstimate:
        """The parameters to render."""

    @property
    def tank(self) -> float:
        """Energy in the tank [J]."""

    @property
    def paid(self) -> float:
        """Energy that updates have added to the springs [J]."""

class LocalModel:
    """The objects of a scene with parameters that arrive over the network."""

    def __init__(self, options: UpdateOptions, scene: palpate._core.Snapshot, planes: bool = False) -> None: ...

    def take(self, estimate: ModelEstimate) -> None:
        """Takes an estimate as the goal of its object."""

    def step(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        v: Annotated[NDArray[numpy.float64], "(3,)"],
        F: Annotated[NDArray[numpy.float64], "(3,)"],
        radius: float,
        t: float,
        dt: float,
    ) -> None:
        """
        Updates for a tool with this radius at p (3,) [m] with velocity v (3,) [m/s] and contact force F (3,) [N], at
        the time t of the scene, dt after the last one [s].
        """

    def synchronise(self, ahead: float) -> None:
        """
        Moving objects are shown ahead of the time that step() is given, where the loop's clock is not the site's [s].
        """

    @property
    def scene(self) -> palpate._core.Snapshot:
        """The objects as they are rendered."""

    def rendered(self, i: int) -> ModelEstimate:
        """The parameters of object i as they are rendered."""

    @property
    def updates(self) -> list[ModelUpdate]:
        """The updates of all objects, in order."""

def concealed(scene: palpate._core.Snapshot, names: Sequence[str]) -> palpate._core.Snapshot:
    """A copy of a scene in which no tool feels the objects with these names."""

def displaced(
    scene: palpate._core.Snapshot,
    shift: Annotated[NDArray[numpy.float64], "(3,)"],
    stiffness: float = 0.0,
) -> palpate._core.Snapshot:
    """
    A copy of a scene with all objects displaced by shift (3,) [m], and with another stiffness [N/m]; 0: as it is.
    """

class Port:
    """Work of a force on a measured position, taken and given apart."""

    def __init__(self) -> None: ...

    def step(self, F: Annotated[NDArray[numpy.float64], "(3,)"], x: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """One tick: force (3,) [N], position (3,) [m]."""

    @property
    def taken(self) -> float:
        """Energy taken, without returns [J]."""

    @property
    def given(self) -> float:
        """Energy given [J]: what was taken less the exact net."""

class Peer:
    """The other end: its clock, the ages of its packets, outages."""

    def __init__(self) -> None: ...

    def receive(self, datagram: Datagram, now: float) -> bool:
        """
        A datagram that arrived at the own time `now` [s]; True if it is newer than all before.
        """

    def step(self, now: float) -> None:
        """One tick at the own time [s]."""

    def stamp(self, datagram: Datagram, now: float) -> None:
        """Fills in the times of a datagram that leaves now [s]."""

    def peer_time(self, now: float) -> float:
        """The peer's time at the own time `now` [s]."""

    @property
    def newest(self) -> Datagram:
        """The newest datagram."""

    @property
    def known(self) -> bool:
        """True once a datagram has arrived."""

    @property
    def outage(self) -> bool:
        """True while packets are missing."""

    @property
    def lost(self) -> bool:
        """True once an outage has lasted, in either direction."""

    @property
    def clock(self) -> ClockSync:
        """The peer's clock."""

    @property
    def arrivals(self) -> Arrivals:
        """Ages of the newest packet."""

class SiteInput:
    """State of the tool at the site, in W."""

    def __init__(self) -> None: ...

    @property
    def t(self) -> float:
        """Own clock, the time of the scene [s]."""

    @t.setter
    def t(self, arg: float, /) -> None: ...

    @property
    def X(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Measured pose (4, 4) [m]."""

    @X.setter
    def X(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Measured velocity (3,) [m/s]."""

    @v.setter
    def v(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def jaw(self) -> float:
        """[rad]."""

    @jaw.setter
    def jaw(self, arg: float, /) -> None: ...

    @property
    def F(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Measured force of the environment on the tool (3,) [N]."""

    @F.setter
    def F(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

class SiteGoal:
    """What the tool shall do."""

    @property
    def X(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose (4, 4) [m]."""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Velocity (3,) [m/s]."""

    @property
    def jaw(self) -> float:
        """[rad]."""

    @property
    def flags(self) -> int:
        """Bits FLAG_*."""

class Site:
    """The follower's end of a link."""

    def __init__(self, options: SiteOptions, scene: palpate._core.Snapshot) -> None: ...

    def receive(self, datagram: Datagram, now: float) -> None:
        """A datagram that arrived at the own time `now` [s]."""

    def step(self, state: SiteInput, dt: float) -> SiteGoal:
        """One tick, dt after the last one [s]; the goal of the tool."""

    def forget_operator(self) -> None:
        """A new operator comes; what was learnt is kept."""

    def rest(self) -> None:
        """
        The tool was moved by others: the goal begins where it is measured next.
        """

    def send(self) -> Datagram:
        """The datagram that leaves now."""

    @property
    def peer(self) -> Peer:
        """The operator's end."""

    @property
    def play_delay(self) -> float:
        """Delay of the motion [s]."""

    @property
    def account(self) -> float:
        """Energy that the tool may still spend [J]."""

class Instrument:
    """A simulated instrument that touches the objects of a scene."""

    def __init__(
        self,
        options: InstrumentOptions,
        radius: float,
        world: palpate._core.Snapshot,
        seed: int = 0,
    ) -> None: ...

    def place(self, p: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """Places the tool at p (3,) [m], at rest."""

    def step(self, goal: SiteGoal, t: float, dt: float) -> None:
        """One tick with this goal from the time t on [s]."""

    def measure(self, t: float) -> SiteInput:
        """What the sensors report at the time t [s]."""

    @property
    def force(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """True force of the tissue (3,) [N]."""

    @property
    def x(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """True position (3,) [m]."""

    @property
    def largest(self) -> float:
        """Largest force of the tissue so far [N]."""

class Alarms:
    """Figures of the detector of outages on one emulated link."""

    @property
    def false_alarms(self) -> int:
        """Outages reported while packets were sent."""

    @property
    def seconds(self) -> float:
        """Virtual time in which they were counted [s]."""

    @property
    def p999(self) -> float:
        """99.9th percentile of the age before the outage [s]."""

    @property
    def limit(self) -> float:
        """Age from which an outage is reported then [s]."""

    @property
    def possible(self) -> float:
        """Age that an hour of this link exceeds once without an outage [s]."""

    @property
    def told(self) -> float:
        """Age at which the outage at the end was reported [s]."""

def count_alarms(condition: Condition, seconds: float, settle: float = 30.0, seed: int = 0) -> Alarms:
    """
    Sends a packet every millisecond for `seconds` of virtual time, then none; counts the outages that are reported. The
    first `settle` seconds do not count.
    """

class OperatorOptions(EndOptions):
    """Options of the operator's end."""

    def __init__(self) -> None: ...

    @property
    def rate(self) -> float:
        """Rate of the cycle [Hz]."""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def stability(self) -> palpate._core.StabilityOptions:
        """Options of the stage `stability`."""

    @stability.setter
    def stability(self, arg: palpate._core.StabilityOptions, /) -> None: ...

    @property
    def update(self) -> UpdateOptions:
        """Limits of updates of the local model."""

    @update.setter
    def update(self, arg: UpdateOptions, /) -> None: ...

class TrialOptions:
    """A simulated teleoperation in virtual time."""

    def __init__(self) -> None: ...

    @property
    def operator_end(self) -> OperatorOptions:
        """Operator's end."""

    @operator_end.setter
    def operator_end(self, arg: OperatorOptions, /) -> None: ...

    @property
    def site(self) -> SiteOptions:
        """Follower's end."""

    @site.setter
    def site(self, arg: SiteOptions, /) -> None: ...

    @property
    def instrument(self) -> InstrumentOptions:
        """Simulated instrument."""

    @instrument.setter
    def instrument(self, arg: InstrumentOptions, /) -> None: ...

    @property
    def to_site(self) -> Condition:
        """Link from the operator to the site."""

    @to_site.setter
    def to_site(self, arg: Condition, /) -> None: ...

    @property
    def to_operator(self) -> Condition:
        """Link from the site to the operator."""

    @to_operator.setter
    def to_operator(self, arg: Condition, /) -> None: ...

    @property
    def every(self) -> int:
        """Ticks between two packets of each end."""

    @every.setter
    def every(self, arg: int, /) -> None: ...

    @property
    def handle_mass(self) -> float:
        """[kg]."""

    @handle_mass.setter
    def handle_mass(self, arg: float, /) -> None: ...

    @property
    def handle_damping(self) -> float:
        """[N s/m]."""

    @handle_damping.setter
    def handle_damping(self, arg: float, /) -> None: ...

    @property
    def hand_mass(self) -> float:
        """[kg]."""

    @hand_mass.setter
    def hand_mass(self, arg: float, /) -> None: ...

    @property
    def hand_damping(self) -> float:
        """[N s/m]."""

    @hand_damping.setter
    def hand_damping(self, arg: float, /) -> None: ...

    @property
    def hand_stiffness(self) -> float:
        """[N/m]."""

    @hand_stiffness.setter
    def hand_stiffness(self, arg: float, /) -> None: ...

    @property
    def clock_offset(self) -> float:
        """Of the site's clock [s]."""

    @clock_offset.setter
    def clock_offset(self, arg: float, /) -> None: ...

    @property
    def clock_drift(self) -> float:
        """Of the site's clock [-]."""

    @clock_drift.setter
    def clock_drift(self, arg: float, /) -> None: ...

    @property
    def settle(self) -> float:
        """Time after first touch and three round trips that does not count [s]."""

    @settle.setter
    def settle(self, arg: float, /) -> None: ...

    @property
    def round_trip(self) -> float:
        """Nominal round trip [s]."""

    @round_trip.setter
    def round_trip(self, arg: float, /) -> None: ...

    @property
    def after_release(self) -> bool:
        """Forces count once the first touch has ended as well."""

    @after_release.setter
    def after_release(self, arg: bool, /) -> None: ...

    @property
    def seed(self) -> int:
        """Seed of links and noise."""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

    def push(self, t: float, object: int, shift: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """Pushes an object aside by shift (3,) [m] at the time t [s]."""

class TrialResult:
    """Figures of a trial; energies by quadrature of the simulated motion."""

    @property
    def energy_hand(self) -> float:
        """
        Lowest energy that the hand has put in, less the work of moving surfaces [J].
        """

    @property
    def energy_site(self) -> float:
        """Lowest gross energy of the hand less net work on the tissue [J]."""

    @property
    def energy_ports(self) -> float:
        """Lowest net energy of the hand less net work on the tissue [J]."""

    @property
    def felt_over_true(self) -> float:
        """Slope of the felt over the true force [-]."""

    @property
    def force_rms(self) -> float:
        """Rms of their difference in contact [N]."""

    @property
    def force_site(self) -> float:
        """Largest force on the tissue [N]."""

    @property
    def kick(self) -> float:
        """Largest change of the force per tick that no motion explains [N]."""

    @property
    def drift(self) -> float:
        """Distance of instrument and hand at the end [m]."""

    @property
    def relearnt(self) -> float:
        """Time from the push until the force is right [s]; negative: never."""

    @property
    def told(self) -> float:
        """Time of the first fixed outage until both ends report it [s]."""

    @property
    def told_site(self) -> float:
        """The same at the site, beyond its p99.9 [s]."""

    @property
    def p999(self) -> float:
        """99.9th percentile of the age at the site [s]."""

    @property
    def round_trip(self) -> float:
        """Sum of the median ages of both directions [s]."""

    @property
    def play_delay(self) -> float:
        """Delay of the played motion at the end [s]."""

    @property
    def clock_error(self) -> float:
        """Error of the site's estimate of the other clock [s]."""

    @property
    def outages(self) -> int:
        """Outages that the site has reported."""

    @property
    def lost(self) -> float:
        """Share of packets to the site that were lost [-]."""

    @property
    def touching(self) -> float:
        """Time in contact that counted [s]."""

    @property
    def palpated(self) -> float:
        """Time of a palpation, since the link stood [s]; negative: not in time."""

def trial_columns() -> list[str]:
    """Names of the columns of the rows of a trial."""

def trial(
    options: TrialOptions,
    world: palpate._core.Snapshot,
    model: palpate._core.Snapshot,
    path: Annotated[NDArray[numpy.float64], "(:, 3)"],
) -> tuple[TrialResult, Annotated[NDArray[numpy.float64], "(:, :)"]]:
    """
    Simulates a hand with the intended path (n, 3) [m], one point per millisecond: (figures, rows (n - 1, 19) with the
    columns trial_columns()). world: the objects as they are; model: as both ends have them.
    """

def palpation(
    options: TrialOptions,
    world: palpate._core.Snapshot,
    model: palpate._core.Snapshot,
    places: Annotated[NDArray[numpy.float64], "(:, 3)"],
    force: float = 1.0,
    most: float = 60.0,
) -> TrialResult:
    """
    Simulates a person who presses the surface below each of the places (n, 3) [m] with this force [N], for at most
    `most` [s]; the figures.
    """

class Ages:
    """Ages of the newest packet at an end."""

    @property
    def age(self) -> float:
        """Age of the newest packet [s]."""

    @property
    def p50(self) -> float:
        """Its median [s]."""

    @property
    def p99(self) -> float:
        """Its 99th percentile [s]."""

    @property
    def p999(self) -> float:
        """Its 99.9th percentile [s]."""

    @property
    def outages(self) -> int:
        """Outages so far."""

class LoopEndOptions(EndOptions):
    """Options of the operator's end in a loop."""

    def __init__(self) -> None: ...

    @property
    def update(self) -> UpdateOptions:
        """Limits of updates of the local model."""

    @update.setter
    def update(self, arg: UpdateOptions, /) -> None: ...

class LinkState(Ages):
    """What is known about a link after a tick."""

    @property
    def newest(self) -> Datagram:
        """The newest datagram of the other end."""

    @property
    def offset(self) -> float:
        """Clock of the other end minus the own one [s]."""

    @property
    def drift(self) -> float:
        """Rate of the other clock minus 1 [-]."""

    @property
    def bound(self) -> float:
        """Error of the offset by an unknown asymmetry of the delays [s]."""

    @property
    def held(self) -> float:
        """Time without link after the first [s]."""

    @property
    def received(self) -> float:
        """Packets that have arrived."""

    @property
    def known(self) -> bool:
        """
        True once an answer has arrived, so that the clock of the other end is known.
        """

    @property
    def linked(self) -> bool:
        """True while the hand feels the remote side."""

    @property
    def outage(self) -> bool:
        """True while packets are missing."""

    @property
    def models(self) -> list[ModelEstimate]:
        """Estimates as rendered, one for each object."""

    @property
    def tank(self) -> float:
        """Least energy in the tanks of the objects [J]."""

    @property
    def paid(self) -> float:
        """
        Energy that updates have added to the springs, less what they took [J].
        """

class LoopEnd(palpate._core.RemoteEnd):
    """The operator's end of a link, for Simulation.attach()."""

    def __init__(self, options: LoopEndOptions, scene: palpate._core.Snapshot) -> None: ...

    def receive(self, bytes: bytes, at: float) -> bool:
        """
        The bytes of a datagram that arrived at the own time `at` [s]; False unless they are valid.
        """

    def packet(self) -> bytes:
        """The bytes of the datagram that leaves next."""

    def state(self) -> LinkState:
        """The state after the newest tick."""

class FollowerOptions:
    """Options of a simulated follower."""

    def __init__(self) -> None: ...

    @property
    def site(self) -> SiteOptions:
        """Follower's end."""

    @site.setter
    def site(self, arg: SiteOptions, /) -> None: ...

    @property
    def instrument(self) -> InstrumentOptions:
        """Simulated instrument."""

    @instrument.setter
    def instrument(self, arg: InstrumentOptions, /) -> None: ...

    @property
    def rate(self) -> float:
        """Rate of its loop [Hz]."""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def realtime(self) -> palpate._core.RealTimeOptions:
        """Options of its thread."""

    @realtime.setter
    def realtime(self, arg: palpate._core.RealTimeOptions, /) -> None: ...

class FollowerState(Ages):
    """What is known about a follower after a tick."""

    @property
    def x(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """True position of the tool (3,) [m]."""

    @property
    def F(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """True force of the tissue (3,) [N]."""

    @property
    def largest(self) -> float:
        """Largest force of the tissue so far [N]."""

    @property
    def account(self) -> float:
        """Energy that the tool may still spend [J]."""

class Follower:
    """The follower's end with a simulated instrument, in a real-time thread."""

    def __init__(
        self,
        options: FollowerOptions,
        scene: palpate._core.Snapshot,
        world: palpate._core.Snapshot,
        X: Annotated[NDArray[numpy.float64], "(4, 4)"],
    ) -> None:
        """
        scene: the objects as both ends have them; world: as they are; X (4, 4): pose of the tool in W [m].
        """

    def start(self) -> None:
        """Starts the thread."""

    def stop(self) -> None:
        """Ends the thread."""

    def receive(self, bytes: bytes, at: float) -> bool:
        """
        The bytes of a datagram that arrived at the own time `at` [s]; False unless they are valid.
        """

    def forget_operator(self) -> None:
        """A new operator comes; what was learnt is kept."""

    def packet(self) -> bytes:
        """The bytes of the datagram that leaves next."""

    def state(self) -> FollowerState:
        """The state after the newest tick."""

    def timing(self) -> dict[str, Any]:
        """
        Punctuality so far: lateness_us, slack_us, ticks, missed_ticks, scheduler.
        """

class EmulatedOptions:
    """Options of an emulated remote site."""

    def __init__(self) -> None: ...

    @property
    def operator_end(self) -> LoopEndOptions:
        """Operator's end."""

    @operator_end.setter
    def operator_end(self, arg: LoopEndOptions, /) -> None: ...

    @property
    def follower(self) -> FollowerOptions:
        """Follower's end, with the rate of the loop."""

    @follower.setter
    def follower(self, arg: FollowerOptions, /) -> None: ...

    @property
    def to_site(self) -> Condition:
        """Link from the operator to the site."""

    @to_site.setter
    def to_site(self, arg: Condition, /) -> None: ...

    @property
    def to_operator(self) -> Condition:
        """Link from the site to the operator."""

    @to_operator.setter
    def to_operator(self, arg: Condition, /) -> None: ...

    @property
    def seed(self) -> int:
        """Seed of the link."""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

class EmulatedEnd(palpate._core.RemoteEnd):
    """
    Both ends, the link and an instrument, for Simulation.attach(): a session across an emulated network in virtual
    time.
    """

    def __init__(self, options: EmulatedOptions, scene: palpate._core.Snapshot, world: palpate._core.Snapshot) -> None:
        """scene: the objects as both ends have them; world: as they are."""

    def state(self) -> LinkState:
        """The state of the operator's end after the newest tick."""
