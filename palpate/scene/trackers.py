"""Section of the scene file for trackers: sources of live poses, limits of trust, and faults of a simulated tracker."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from palpate.base.values import NotNegative, Positive, Section
from palpate.scene.stability import Share
from palpate.scene.tissue import Motions


class FaultSection(Section):
    """A fault of the simulated tracker."""

    kind: Literal["occluded", "swapped-spheres", "swapped-tools", "stopped"]
    """occluded: no pose; swapped-spheres: two spheres of a marker confused; swapped-tools: two tools confused; stopped:
    no pose of any tool"""
    start: NotNegative
    """start [s]"""
    end: Positive = 1e9
    """end [s]"""
    tool: str = ""
    """name of the tool; every tool when left out"""


class SimulatedSection(Section):
    """A simulated optical tracker of rigid markers with four spheres each."""

    rate: Annotated[Positive, Field(le=1000.0)] = 60.0
    """frames per second [Hz]"""
    noise_mm: NotNegative = 0.25
    """noise of the position of each sphere, standard deviation on each axis [mm]"""
    delay_ms: Annotated[NotNegative, Field(le=200.0)] = 0.0
    """time from a frame to its arrival [ms]"""
    dropout: Share = 0.0
    """fraction of the frames that are lost [-]"""
    motion: dict[str, Motions] = Field(default_factory=dict)
    """motion of each tool from its pose in frames, in the tracker's axes; a tool without an entry rests"""
    faults: tuple[FaultSection, ...] = ()
    """faults to simulate"""


def _address(value: str) -> str:
    if re.fullmatch(r"[\w.-]+:\d{1,5}", value) and int(value.rsplit(":", 1)[1]) < 65536:
        return value
    raise ValueError(f"{value!r} is not an address | write host:port, such as 127.0.0.1:18944")


def _topic(value: str) -> str:
    if re.fullmatch(r"(/([A-Za-z_]|\{tool\})(\w|\{tool\})*)+", value):
        return value
    raise ValueError(f"{value!r} is not a topic | write an absolute name, such as /polaris/{{tool}}/measured_cp")


class TrackerSection(Section):
    """A tracker: simulated, an OpenIGTLink server or a ROS 2 topic, with the limits of trust in its poses."""

    simulated: SimulatedSection | None = None
    """a simulated tracker in the same process"""
    openigtlink: Annotated[str, AfterValidator(_address)] | None = None
    """instead: host:port of an OpenIGTLink server, such as PLUS or 3D Slicer"""
    topic: Annotated[str, AfterValidator(_topic)] | None = None
    """instead: a ROS 2 topic of PoseStamped, such as /polaris/{tool}/measured_cp; {tool} is the tool of each frame"""
    delay_ms: Annotated[NotNegative, Field(le=200.0)] = 0.0
    """time from a measurement to its stamp, or to its arrival if the clock of the stamps is not this machine's [ms]"""
    max_age: Positive = 0.2
    """age of the newest pose above which the tool counts as lost [s]"""
    max_error_mm: Positive = 1.0
    """largest rms residual of a marker's spheres that is accepted, where the tracker reports it [mm]"""
    max_speed: Positive = 0.25
    """largest plausible speed of a tool; a faster change is a jump, and is not followed [m/s]"""
    max_turn_deg: Positive = 180.0
    """largest plausible angular speed of a tool [deg/s]"""
    fade: NotNegative = 0.5
    """time in which the force of objects that follow a lost tool falls to zero; 0: the force stays [s]"""
    speed: Annotated[Positive, Field(le=1.0)] = 0.1
    """largest speed of the objects that follow this tracker [m/s]"""
    turn_deg: Annotated[Positive, Field(le=360.0)] = 60.0
    """largest angular speed of the objects that follow this tracker [deg/s]"""
    acceleration: Annotated[Positive, Field(le=10.0)] = 0.5
    """largest acceleration of the objects that follow this tracker [m/s^2]"""

    @model_validator(mode="after")
    def _check(self) -> TrackerSection:
        given = [key for key in ("simulated", "openigtlink", "topic") if getattr(self, key) is not None]
        if len(given) != 1:
            count = " and ".join(given) + " are given" if given else "no source is given"
            raise ValueError(
                f"{count} | give one of simulated: {{}}, openigtlink: HOST:PORT and topic: /NAME/measured_cp"
            )
        return self
