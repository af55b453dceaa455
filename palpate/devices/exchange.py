"""How fast and how punctual is the exchange with Haply's service? Beside a bare echo client on the same machine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.haply.driver import Haply
from palpate.devices.haply.service import Address, websocket
from palpate.devices.session import DrivenSession
from palpate.scene.scene import Scene

TRIPS = 2000
"""Number of round trips that are timed, of each kind."""
_TEXT = "x" * 120  # as long as a command of a force


@dataclass(frozen=True)
class Exchange:
    """Round trips at zero force one after the other, and a haptic session at the rate of the driver."""

    trip_p50_us: float  # a command, and the state of the device
    trip_p99_us: float
    echo_p50_us: float  # a text of the same length, and its echo by a bare server
    echo_p99_us: float
    rate_Hz: float  # of the session
    ticks: int
    missed: int  # ticks of the session that came a period late or more
    lateness_p99_us: float

    def in_words(self) -> str:
        """The figures in two sentences."""
        trips = f"round trip p50 {self.trip_p50_us:.0f} us, p99 {self.trip_p99_us:.0f} us"
        echo = f"a bare echo {self.echo_p50_us:.0f} and {self.echo_p99_us:.0f} us"
        ticks = f"at {self.rate_Hz:g} Hz {self.missed} of {self.ticks} ticks were missed"
        return f"{trips}; {echo}; {ticks}, lateness p99 {self.lateness_p99_us:.0f} us"


def measure_exchange(name: str, seconds: float) -> Exchange:
    """Time round trips, and then run a session with a plane for a time [s].

    Args:
        name: the driver with its options, such as ``haply:rate=2000``.
        seconds: duration of the session.

    Raises:
        DeviceError: it is no Haply, or the service or the device is missing.
    """
    head, _, argument = name.partition(":")
    if head != "haply":
        raise DeviceError(f"{name} exchanges no messages", mend="--exchange is for the driver haply")
    out = np.zeros(TRIPS)
    made = Haply(argument).native().round_trips(out)
    trips, echo = out[:made], _echo()
    if made < TRIPS:
        raise DeviceError(f"the service answered {made} of {TRIPS} messages", mend="see palpate device list")
    objects = [{"name": "plane", "plane": {}, "stiffness": 400.0}]
    far = {"xyz": [0.0, 0.0, 0.012]}
    path = [{"t": 0.0, **far}, {"t": 1.0, **far}]
    scene = {"objects": objects, "arms": {"leader": {"driver": name}}, "operator": {"path": path}}
    session = DrivenSession(Scene.model_validate(scene))
    summary, timing = session.run(seconds), session.timing
    p50, p99, echo50, echo99 = (1e6 * float(np.percentile(x, q)) for x in (trips, echo) for q in (50, 99))
    late = float(timing["lateness_us"]["p99"])
    return Exchange(p50, p99, echo50, echo99, session.rate, summary.ticks, summary.missed_ticks, late)


def _echo() -> Array:
    """Round trips of a bare client with a server that sends each text back [s]."""
    from palpate.devices.haply.wire import Connection, Port

    def echo(connection: Connection) -> None:
        while connection.open:
            for text in connection.messages():
                connection.send(text)

    port = Port("127.0.0.1", 0, lambda method, path, body: (404, None), echo)
    try:
        out = np.zeros(TRIPS)
        made = websocket(Address("127.0.0.1", port.number)).round_trips(_TEXT, out)
        return out[:made]
    finally:
        port.close()
