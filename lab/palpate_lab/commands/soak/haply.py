"""`palpate soak haply`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Let Haply's service hang, slow down, talk nonsense and die while its device is pressed; time until zero force.

    examples:
      palpate soak haply
      palpate soak haply --repeats 100 --json silence.json

    The service is a stand-in in a process of its own (docs/haply.md). A force for longer than 20 ms (at the motors of a
    slow service: than the time that no client can undercut, in the column bound), or a fault that the session does not
    name, is counted, and the exit code is then 1.
    """

    repeats: int = 10
    """Cases of each fault [-]."""
    rate: float = 2000.0
    """Messages per second [Hz]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the times as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Let each fault happen, print the times, write the JSON contract. Returns 1 if a force stayed too long."""
        from rich.markup import escape
        from rich.table import Table

        from palpate_lab.verify.soak.haply import run

        console = console_for(self.json)
        require_writable(self.json)
        if not 1 <= self.repeats <= 10_000:
            raise PalpateError(f"--repeats {self.repeats}: must be 1 to 10,000", mend="--repeats 10")
        found = run(self.repeats, self.rate, progress=lambda fault: say(console, f"{self.repeats} times", f"{fault}:"))
        table = Table(box=None, pad_edge=False)
        for column in ("fault", "rendered: p50, max [ms]", "at the motors: p50, max [ms]", "bound [ms]", "named"):
            table.add_column(escape(column))
        for one in found:
            motors = "-" if one.motors_p50_ms is None else f"{one.motors_p50_ms:.1f}, {one.motors_max_ms:.1f}"
            rendered = f"{one.rendered_p50_ms:.1f}, {one.rendered_max_ms:.1f}"
            least = "-" if one.motors_p50_ms is None else f"{one.bound_ms:.1f}"
            table.add_row(one.fault, rendered, motors, least, f"{one.named} of {one.cases}")
        console.print(table)
        late = sum(one.late for one in found)
        say(console, f"{late} of {sum(one.cases for one in found)} cases above 20 ms, or of slow above its bound")
        write_json(self.json, {"rate_Hz": self.rate, "faults": found})
        return int(any(one.bad for one in found))
