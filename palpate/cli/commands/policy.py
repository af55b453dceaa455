"""`palpate policy`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Let a policy (ONNX, or a Python function) drive the follower of a scene in the haptic loop, and record it.

    examples:
      palpate policy nodule policy.onnx --duration 10
      palpate policy palpation my_policy.py:act --rate 30 --realtime
      palpate policy palpation my_policy.py:act --device simulated --authority pedal

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
    device: Annotated[str | None, arg(metavar="NAME")] = None
    """Share the authority with a person who holds this device (a name of `palpate device list`); in real time."""
    authority: Literal["pedal", "gripper"] = "pedal"
    """With --device: the person drives while the device's clutch is pressed, or while its gripper is closed."""
    out: Annotated[Path, arg(metavar="DIR")] = Path("runs")
    """Folder in which the run gets its own folder."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json/export.md); - for the standard output."""

    def __call__(self) -> int:
        """Drive, and say what became of it."""
        from palpate.devices.open import open_python_driver
        from palpate.gym.drive import drive
        from palpate.gym.policy import load_policy
        from palpate.gym.shared import share

        console = console_for(self.json)
        require_writable(self.json)
        policy = load_policy(self.policy)
        if self.device is None:
            done = drive(self.scene, policy, self.duration, rate=self.rate, record=self.out, realtime=self.realtime)
            summary, actions, notes = done.summary, done.actions, list(done.notes)
        else:
            driver = open_python_driver(self.device, Path())
            summary, mixer = share(
                self.scene, policy, driver, self.duration, authority=self.authority, rate=self.rate, record=self.out
            )
            actions, notes = mixer.asked.count, mixer.asked.notes
        for note in notes:
            say(console, note, "policy:", "yellow")
        for fault in summary.faults if self.device is not None else ():
            say(console, fault, "fault:", "red")
        say(console, f"{actions} actions; largest force on the hand {summary.peak_force_N:.2f} N, "
            f"{summary.peak_50ms_N:.2f} N over 50 ms")  # fmt: skip
        say(console, str(summary.record), "record")
        found = {
            "actions": actions, "notes": notes, "peak_force_N": summary.peak_force_N,
            "peak_50ms_N": summary.peak_50ms_N, "duration_s": self.duration, "record": summary.record,
            "faults": list(summary.faults),
        }  # fmt: skip
        write_json(self.json, found)
        return 0
