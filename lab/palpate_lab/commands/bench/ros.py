"""`palpate bench ros`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.console import Console


@dataclass
class Command:
    """Measure the latency from a leader's state to its wrench over ROS 2, next to a bare echo as a control.

    examples:
      palpate bench ros --duration 600 --json ros.json
      palpate bench ros --sim
      palpate bench ros --discovery
      palpate bench ros --faults --tries 20
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    duration: float = 20.0
    """Duration of the measurement [s]."""
    rate: float = 1000.0
    """Rate at which the leader publishes its state [Hz]."""
    sim: bool = False
    """Also measure the rate that `palpate ros sim` reaches with four arms, and the CPU cores it uses."""
    discovery: bool = False
    """Measure instead how soon a client that starts beside the simulated robot hears and is heard."""
    starts: int = 20
    """Number of clients that --discovery starts beside the robot, and beside its control [-]."""

    faults: bool = False
    """Measure instead how soon after a fault the hand is free: silence, wrong messages, stopped processes."""
    tries: int = 20
    """How often --faults plants each fault [-]."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import ros

        console = console_for(self.json)
        require_writable(self.json)
        if not 1.0 <= self.duration <= 86400.0 or not 50.0 <= self.rate <= 5000.0:
            raise PalpateError(
                "--duration: 1 to 86400 s; --rate: 50 to 5000 Hz", mend="e.g. --duration 600 --rate 1000"
            )
        if self.discovery:
            return self._discovery(console)
        if self.faults:
            return self._faults(console)
        figures = ros.run(self.duration, self.rate, on_progress=lambda text: say(console, text))
        if self.sim:
            figures |= ros.of_sim()
            words = f"{figures['sim_rate_hz']:.0f} Hz reached, {figures['sim_cores']:.2f} cores"
            say(console, f"palpate ros sim with four arms: {words}")
        console.print(ros.table(figures))
        write_json(self.json, figures)
        return 0

    def _discovery(self, console: Console) -> int:
        from palpate_lab.verify.bench import ros_discovery

        if not 1 <= self.starts <= 1000:
            raise PalpateError(f"--starts {self.starts}: must be 1 to 1000", mend="e.g. --starts 20")
        figures = ros_discovery.run(self.starts, on_progress=lambda text: say(console, text))
        console.print(ros_discovery.table(figures))
        write_json(self.json, figures)
        return 0

    def _faults(self, console: Console) -> int:
        from palpate_lab.verify.bench import ros_faults

        if not 1 <= self.tries <= 1000:
            raise PalpateError(f"--tries {self.tries}: must be 1 to 1000", mend="e.g. --tries 20")
        figures = ros_faults.run(self.tries, self.rate, on_progress=lambda text: say(console, text))
        console.print(ros_faults.table(figures))
        write_json(self.json, figures)
        return 0
