"""`palpate soak ros`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate_lab.verify.soak.ros_row import Row


@dataclass
class Command:
    """Run the haptic node beside the simulated robot for days, while a simulated hand presses on a wall.

    examples:
      palpate soak ros
      palpate soak ros --hours 4 --log night.jsonl --json night.json

    It counts missed states, takeovers by the guardian, printed lines and memory. After Ctrl-C, or when the machine has
    restarted, the same command continues the log.
    """

    hours: float = 50.0
    """Time that the log shall hold in the end [h]."""
    interval: float = 60.0
    """Interval of the rows [s]."""
    log: Annotated[Path, arg(metavar="FILE")] = Path("soak-ros.jsonl")
    """File to which the rows are appended; its folder also takes the node's records while it runs."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the result as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Soak, print rows and result, write the JSON contract. Returns 1 if anything is wrong."""
        from palpate_lab.verify.soak.ros import run, table

        console = console_for(self.json)
        require_writable(self.json)
        require_writable(self.log)

        def show(row: Row) -> None:
            memory = ", ".join(f"{part} {value:.0f} MB" for part, value in row.memory_MB.items())
            say(console, f"{row.t_s / 3600:8.3f} h  {row.wrenches:,} wrenches for {row.states:,} states, "
                         f"{row.touches} touches, guardian {row.guarded}, {row.lines} lines; {memory}; "
                         f"load {row.load:.1f}")  # fmt: skip

        done = run(self.hours, self.log, self.interval, show)
        console.print(table(done))
        write_json(self.json, done)
        return 1 if done.wrong else 0
