# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""Haply devices through the vendor's Inverse Service."""

from typing import Annotated

import numpy
from numpy.typing import NDArray

import palpate._core


class Connection:
    """The client's end of a WebSocket, after the handshake."""

    def __init__(self, socket: int) -> None:
        """Takes over the file descriptor of a connected socket."""

    def send(self, text: str) -> None:
        """Sends a text. Raises RuntimeError if the connection is broken."""

    def receive(self, seconds: float) -> str:
        """Waits for a message [s]. Raises RuntimeError without one."""

    def receive_bytes(self, seconds: float) -> bytes:
        """As receive(), for messages that are no valid text."""

    def round_trips(self, text: str, out: Annotated[NDArray[numpy.float64], "(:,)"]) -> int:
        """
        Sends a text and waits for the answer, as often as `out` (n,) is long; writes the times [s] to it. Returns how
        many there were.
        """

    def pace(self, text: str, rate: float, n: int) -> tuple[int, int, int]:
        """
        Sends a text `n` times at a rate [Hz], from a thread like that of a driver, and takes each answer one period
        later. Returns the texts sent, the ticks missed, and the answers that were not there after a period.
        """

class Device(palpate._core.Driver):
    """A Haply device: a driver for the thread of the core."""

    def __init__(
        self,
        service: Connection,
        events: Connection | None,
        *,
        device: str,
        address: str,
        grip: str,
        list: str,
        vector: bool,
        rate: float,
        force_max: float,
        workspace: float,
    ) -> None:
        """
        service: the connection after its inventory; events: that of the events, or None. device, grip: their ids;
        address: the id of the device as JSON, as the service wrote it; list: the list of the messages in which the grip
        is; vector: the service is 3.5 or later.
        """

    def read(self, X: Annotated[NDArray[numpy.float64], "(4, 4)"]) -> tuple[int, float] | None:
        """
        Writes the pose (4, 4) [m] to X. Returns the buttons and the angle of the gripper [rad], or None if there is no
        measurement. Raises RuntimeError if the device is lost.
        """

    def write(self, F: Annotated[NDArray[numpy.float64], "(6,)"]) -> None:
        """
        Commands the force of a wrench (6,) [N]. Raises RuntimeError if the device is lost.
        """

    def round_trips(self, out: Annotated[NDArray[numpy.float64], "(:,)"]) -> int:
        """
        Commands zero force and reads the answer, as often as `out` (n,) is long; writes the times [s] to it.
        """

    @property
    def exchanges(self) -> int:
        """Number of answers of the service so far."""

    @property
    def late(self) -> int:
        """Number of answers that were not there when the next tick began."""

class Reader:
    """Reads the messages of the service, as the driver does in its cycle."""

    def __init__(self, device: str, grip: str, list: str) -> None: ...

    def read(self, text: bytes) -> tuple[list[float], list[float], list[float], bool, bool, bool] | None:
        """
        Position (3,) [m], velocity (3,) [m/s], orientation (4,) as x, y, z, w, calibrated, ready and button a of an
        answer; None if it is no valid state of the device.
        """

    def read_event(self, text: bytes) -> int:
        """Kind of an event; 0: it concerns no force of this device."""
