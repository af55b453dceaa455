"""`palpate ros sim`."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import dataclass
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Simulate a dVRK on ROS 2: arms, console, pedals and teleoperation under the topic names of the real robot.

    examples:
      palpate ros sim
      palpate ros sim --arms MTMR PSM1 --rate 500
      palpate ros topic pub /MTMR/state_command crtk_msgs/msg/StringStamped "{string: home}"

    The MTMs have dynamics: they move under servo_cf, and fall without gravity compensation. Ctrl-C ends the simulation.
    """

    arms: tuple[str, ...] = ("MTMR", "MTML", "PSM1", "PSM2", "PSM3", "ECM")
    """Arms among MTMR, MTML, PSM1, PSM2, PSM3, ECM; the pairs MTMR_PSM1 and MTML_PSM2 get a teleoperation."""
    rate: Annotated[float, arg(metavar="HZ")] = 1000.0
    """Rate of the measured states, 1 to 1000 [Hz]. A real dVRK has 100 Hz unless it is started with -p 0.001."""
    force: bool = False
    """Start even if another program has arms of these names; both then obey the same commands."""
    network: bool = False
    """Communicate with other machines; otherwise only within this one."""
    head_sensor: bool = False
    """A head sensor reports the operator's presence (/console/emulate_operator_present); otherwise the coag pedal."""
    meter: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Interval of a status line: rate reached, late servo ticks, commands, CPU cores [s]; no line when left out."""

    def __call__(self) -> int:
        """Simulate until Ctrl-C."""
        from palpate.ros import sim

        console = console_for(None)
        robot = sim.start(
            self.arms,
            rate=self.rate,
            network=self.network,
            head_sensor=self.head_sensor,
            force=self.force,
            on_progress=lambda text: say(console, text),
        )
        reach = "open to the network" if self.network else "this machine alone"
        try:
            say(console, f"simulated dVRK: {', '.join(self.arms)}; {robot.rate:g} Hz, {reach}, {robot.scheduler}")
            say(console, "Ctrl-C ends it")
            sys.stdout.flush()
            meter = sim.Meter(robot)
            while True:
                time.sleep(self.meter or 0.2)
                if self.meter:
                    now = meter.read()
                    words = f"{now['missed']:.0f} servo ticks late, {now['commands']:.0f} commands"
                    say(console, f"{now['rate']:.0f} Hz, {words}, {now['cores']:.2f} cores")
                    sys.stdout.flush()
        except KeyboardInterrupt:
            for end in (signal.SIGINT, signal.SIGTERM):
                signal.signal(end, signal.SIG_IGN)  # the shutdown takes a tenth of a second
            robot.stop()
        say(console, f"ended, arms powered off; {robot.commands} commands taken, {robot.dropped} lost")
        return 0
