"""`palpate bench execution`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure how long a planned motion at full speed takes to rest after a stop, in lockstep, real time, or on ROS 2.

    examples:
      palpate bench execution --json execution.json
      palpate bench execution --stops 10
      palpate bench execution --ros --stops 20
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json/plan.md); - for the standard output."""
    stops: int = 100
    """Number of stops [-]."""
    ros: bool = False
    """Stop `palpate ros move` on the simulated arm of `palpate ros sim` instead, by servo_jp and by move_jp."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.planning.geometry import require
        from palpate_lab.verify.bench import execution, execution_ros

        console = console_for(self.json)
        require_writable(self.json)
        require()
        if self.stops < 1:
            raise ValueError(f"--stops must be 1 or more. Got: {self.stops}")
        run = execution_ros.run if self.ros else execution.run
        rows = run(self.stops, lambda text: say(console, text))
        console.print(execution.table(rows))
        write_json(self.json, rows)
        return 0
