"""How fast and how punctual is the exchange with Haply's service? Beside a bare echo client on the same machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from palpate import _core
from palpate.base.errors import DeviceError
from palpate.devices.haply.driver import Haply
from palpate.devices.haply.service import Address, websocket
from palpate.scene.scene import Scene
from palpate.session.session import Session

if TYPE_CHECKING:
    from palpate import _haply
    from palpate.devices.haply.wire import Connection, Port

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
    late: int  # answers of the service that were not there after a period: the tick waited for them
    lateness_p99_us: float
    echo_ticks: int  # of the bare client at the same rate for the same time
    echo_missed: int
    echo_late: int

    def in_words(self) -> str:
        """The figures in one sentence."""
        trips = f"round trip p50 {self.trip_p50_us:.0f} us, p99 {self.trip_p99_us:.0f} us"
        echo = f"a bare echo {self.echo_p50_us:.0f} and {self.echo_p99_us:.0f} us"
        late = f"{self.late} answers were not there after a period"
        ticks = f"at {self.rate_Hz:g} Hz {self.missed} of {self.ticks} ticks were missed, {late}"
        beside = (
            f"of a bare echo at that rate {self.echo_missed} of {self.echo_ticks} were missed, {self.echo_late} late"
        )
        return f"{trips}; {echo}; {ticks}, lateness p99 {self.lateness_p99_us:.0f} us; {beside}"


def measure_exchange(name: str, seconds: float) -> Exchange:
    """Time round trips, run a session with a plane for a time [s], and a bare echo at the same rate for as long.

    Args:
        name: the driver with its options, such as ``haply:rate=2000``.
        seconds: duration of the session.

    Raises:
        DeviceError: it is no Haply, or the service or the device is missing.
    """
    from palpate import _haply

    head, _, argument = name.partition(":")
    if head != "haply":
        raise DeviceError(f"{name} exchanges no messages", mend="--exchange is for the driver haply")
    out = np.zeros(TRIPS)
    made = Haply(argument).native().round_trips(out)
    if made < TRIPS:
        raise DeviceError(f"the service answered {made} of {TRIPS} messages", mend="see palpate device list")
    objects = [{"name": "plane", "plane": {}, "stiffness": 400.0}]
    far = {"xyz": [0.0, 0.0, 0.012]}
    path = [{"t": 0.0, **far}, {"t": 1.0, **far}]
    scene = {"objects": objects, "arms": {"leader": {"driver": name}}, "operator": {"path": path}}
    session = Session(Scene.model_validate(scene))
    summary, timing = session.run(seconds), session.timing
    device = session.plant.driver
    assert isinstance(device, _haply.Device)
    with echo_server() as port:
        echo = np.zeros(TRIPS)
        echo = echo[: _to(port).round_trips(_TEXT, echo)]
        paced = _to(port).pace(_TEXT, session.rate, max(1, round(seconds * session.rate)))
    p50, p99, echo50, echo99 = (1e6 * float(np.percentile(x, q)) for x in (out, echo) for q in (50, 99))
    late = float(timing["lateness_us"]["p99"])
    missed = summary.missed_ticks
    return Exchange(p50, p99, echo50, echo99, session.rate, summary.ticks, missed, device.late, late, *paced)


def _to(port: Port) -> _haply.Connection:
    return websocket(Address("127.0.0.1", port.number))


@contextmanager
def echo_server() -> Iterator[Port]:
    """A bare server that sends each text back, on a free port, with the priority that the stand-in has."""
    from palpate.devices.haply.wire import Port

    def echo(connection: Connection) -> None:
        _core.schedule(True)
        while connection.open:
            for text in connection.messages():
                connection.send(text)

    port = Port("127.0.0.1", 0, lambda method, path, body: (404, None), echo)
    try:
        yield port
    finally:
        port.close()
