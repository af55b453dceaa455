"""`palpate bench gym`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Steps per second of environments of Gymnasium that step together, beside a bare arm of MuJoCo.

    examples:
      palpate bench gym
      palpate bench gym --instruments 256 --seconds 20 --json gym.json
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    instruments: int = 64
    """Number of environments that step together."""
    substeps: int = 20
    """Ticks of 1 ms in a step."""
    seconds: float = 5.0
    """Time of the measurement [s]."""

    def __call__(self) -> int:
        """Measure, print the figures, write the JSON contract."""
        from palpate_lab.verify.bench import gym

        console = console_for(self.json)
        require_writable(self.json)
        found = gym.run(self.instruments, self.substeps, self.seconds)
        cpu = "processor time of one"
        say(
            console,
            f"{found['steps_per_s']:,.0f} steps/s of {found['step_ms']:g} ms of simulated time ({found['substeps']} "
            f"ticks of the haptic cycle) by {found['workers']} threads; {cpu}: {found['cpu_us_per_step']:.1f} us; "
            f"of a reset with a drawn stiffness: {found['reset_ms']:.1f} ms; load {found['load']:.1f}",
        )
        if found["control_steps_per_s"]:
            say(
                console,
                f"control: a bare arm of {found['control_joints']} joints in MuJoCo without contact, as many ticks a "
                f"step: {found['control_steps_per_s']:,.0f} steps/s on one core; "
                f"{cpu}: {found['control_cpu_us_per_step']:.1f} us, of which ours takes "
                f"{found['ratio_to_control']:.2f} times as much",
            )
        write_json(self.json, found)
        return 0
