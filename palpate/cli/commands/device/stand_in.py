"""`palpate device stand-in`."""

from __future__ import annotations

import gc
import time
from dataclasses import dataclass
from typing import Annotated, Literal

from tyro.conf import Positional, UseAppendAction, arg

from palpate.base.errors import DeviceError
from palpate.cli.terminal.output import console_for, say

_FOR_TWO = "rate=1000"  # one process answers for all devices: at 2 kHz two of them miss many ticks on two cores
_FIRST, _MOST = 0x04C3, 8  # id of the first device; number of hands that a scene may have


@dataclass
class Command:
    """Stand in for a vendor's service, with a simulated device behind it: try a device that you do not have.

    examples:
      palpate device stand-in haply
      palpate device stand-in haply --port 10101 --dialect 3.1 --free
      palpate device stand-in haply --fault hang@10+1 --fault sleep@20
      palpate device stand-in haply --devices 2 --fault unplug:04C4@20

    It answers on 127.0.0.1 as Haply's Inverse Service does (docs/haply.md), until Ctrl-C. A simulated hand moves the
    device down and up by 130 mm every 8 s.
    """

    service: Positional[Literal["haply"]]
    """The service to stand in for."""
    port: int = 10001
    """Port of HTTP and of the WebSocket; events are 19 ports above. 0: free ones."""
    dialect: Literal["3.0", "3.1", "3.4", "3.5"] = "3.5"
    """Version of the service whose messages it speaks."""
    devices: Annotated[int, arg(metavar="N")] = 1
    """Number of devices behind the service, one for each hand in turns: 04C3, 04C4, ..."""
    free: bool = False
    """Nobody holds the device: commanded forces alone move it."""
    no_grip: bool = False
    """Without a VerseGrip: no orientation and no buttons."""
    minverse: bool = False
    """A Minverse in place of an Inverse3."""
    left: bool = False
    """A device for the left hand."""
    idle_after: Annotated[float, arg(metavar="SECONDS")] = 0.02
    """Time without a message after which the motors are idle [s]."""
    fault: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="NAME[:DEVICE][=VALUE][@SECONDS[+SECONDS]]")] = ()
    """What goes wrong, from a time on and for a time, of one device or of all: late, slow, hang, disconnect,
    malformed, sleep, battery, ebrake, stall, unplug, uncalibrated, duplicate."""

    def __call__(self) -> int:
        """Serve until Ctrl-C; returns the exit code."""
        try:
            from palpate.devices.haply.stand_in import Fault, Options, StandIn
        except ImportError as error:
            mend = "pip install 'palpate[haply]'"
            raise DeviceError("the stand-in needs the package websockets", why=str(error), mend=mend) from None
        if not 1 <= self.devices <= _MOST:
            raise DeviceError(f"--devices {self.devices}: must be 1 to {_MOST}", mend="give e.g. --devices 2")
        options = Options(
            more=tuple(f"{_FIRST + i:04X}" for i in range(1, self.devices)),
            dialect=self.dialect,
            minverse=self.minverse,
            handedness="left" if self.left else "right",
            held=not self.free,
            idle_after=self.idle_after,
            faults=tuple(map(Fault.parse, self.fault)),
        )
        if self.no_grip:
            options.grip = None
        console = console_for(None)
        with StandIn(self.port, options=options) as service:
            name = f"{'Minverse' if self.minverse else 'Inverse3'} {', '.join(service.devices)}, service {self.dialect}"
            say(console, f"{name}: ws://127.0.0.1:{service.port}, events on port {service.events_port}", "stand-in:")
            say(console, self._run_with(list(service.devices), service.port), "feel it:")
            self._serve()
        return 0

    def _run_with(self, ids: list[str], port: int) -> str:
        """The command that feels a scene on the first device, or on the first two."""
        url = [] if port == 10001 else [f"url=ws://127.0.0.1:{port}"]
        if len(ids) == 1:
            return f"palpate run palpation --leader {':'.join(['haply', *url])}"
        hands = (f"--leader {hand}=haply:{','.join([f'id={id}', f'grip={1102 + i}', *url, _FOR_TWO])}"
                 for i, (hand, id) in enumerate(zip(("right", "left"), ids, strict=False)))  # fmt: skip
        return f"palpate run two_hands {' '.join(hands)}"

    def _serve(self) -> None:
        gc.collect()
        gc.freeze()  # a full collection goes through all that was imported: it held up answers for 20 ms
        while True:
            time.sleep(0.1)
