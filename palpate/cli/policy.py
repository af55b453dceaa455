"""`palpate policy`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.console.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Let a policy (ONNX, or a Python function) drive the follower of a scene in the haptic loop, and record it.

    examples:
      palpate policy nodule policy.onnx --duration 10
      palpate policy palpation my_policy.py:act --rate 30 --realtime

    Caps, guidance and watchdog of the scene act as for a person's device (docs/learning.md).
    """

    scene: Positional[Path]
    """Scene file (YAML), or the name of a shipped scene."""
    policy: Positional[str]
    """FILE.onnx, FILE.py:NAME or MODULE:NAME: from an observation to the velocity of the tool's goal (6,)."""
    duration: float = 10.0
    """Simulated time [s]."""
    rate: Annotated[float, arg(metavar="HZ")] = 50.0
    """Actions per second."""
    realtime: bool = False
    """Run in real time, with the policy in a thread of its own."""
    out: Annotated[Path, arg(metavar="DIR")] = Path("runs")
    """Folder in which the run gets its own folder."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json/export.md); - for the standard output."""

    def __call__(self) -> int:
        """Drive, and say what became of it."""
        from palpate.gym.drive import drive
        from palpate.gym.policy import load_policy

        console = console_for(self.json)
        require_writable(self.json)
        policy = load_policy(self.policy)
        done = drive(self.scene, policy, self.duration, rate=self.rate, record=self.out, realtime=self.realtime)
        summary = done.summary
        for note in done.notes:
            say(console, note, "policy:", "yellow")
        say(console, f"{done.actions} actions; largest force on the hand {summary.peak_force_N:.2f} N")
        say(console, str(summary.record), "record")
        found = {"actions": done.actions, "notes": list(done.notes), "peak_force_N": summary.peak_force_N,
                 "duration_s": self.duration, "record": summary.record, "faults": list(summary.faults)}  # fmt: skip
        write_json(self.json, found)
        return 0
