"""`palpate ros sim`."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import dataclass
from typing import Annotated

from tyro.conf import arg

from palpate.console.output import console_for, say


@dataclass
class Command:
    """A dVRK one can talk to: simulated arms, console, pedals and teleoperations under the real one's names.

    examples:
      palpate ros sim
      palpate ros sim --arms MTMR PSM1 --rate 1000
      ros2 topic pub --once /MTMR/state_command crtk_msgs/msg/StringStamped "{string: home}"

    The MTMs move by their dynamics: they yield to servo_cf, and fall when gravity compensation is off. Ctrl-C ends it.
    """

    arms: tuple[str, ...] = ("MTMR", "MTML", "PSM1", "PSM2", "ECM")
    """Of MTMR, MTML, PSM1, PSM2, PSM3, ECM; MTMR_PSM1 and MTML_PSM2 are teleoperated where both are there."""
    rate: Annotated[float, arg(metavar="HZ")] = 100.0
    """Of what the arms measure, 1 to 1000 [Hz]."""
    network: bool = False
    """Other machines may talk to it; otherwise this one alone."""
    meter: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Every so often a line with the rate that is reached, late servo ticks, commands and cores [s]."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.ros import sim

        console = console_for(None)
        robot = sim.start(self.arms, rate=self.rate, network=self.network, on_progress=lambda text: say(console, text))
        reach = "open to the network" if self.network else "this machine alone"
        try:
            say(console, f"simulated dVRK: {', '.join(self.arms)}; {robot.rate:g} Hz, {reach}, {robot.scheduler}")
            say(console, "Ctrl-C ends it")
            sys.stdout.flush()
            meter = sim.Meter(robot)
            while True:
                time.sleep(self.meter or 0.2)
                if self.meter:
                    now = meter.look()
                    words = f"{now['missed']:.0f} servo ticks late, {now['commands']:.0f} commands"
                    say(console, f"{now['rate']:.0f} Hz, {words}, {now['cores']:.2f} cores")
                    sys.stdout.flush()
        except KeyboardInterrupt:
            for end in (signal.SIGINT, signal.SIGTERM):
                signal.signal(end, signal.SIG_IGN)  # it is ending: a tenth of a second
            robot.stop()
        say(console, f"ended, arms powered off; {robot.commands} commands taken, {robot.dropped} lost")
        return 0
