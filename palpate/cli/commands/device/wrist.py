"""`palpate device wrist`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Certify rotational springs on a wrist axis of a master, from a recording of its angle and commanded torque.

    examples:
      palpate device wrist roll.csv
      palpate device wrist roll.csv --stiffness 0.2 --damping 0.002 --json roll.json

    The CSV has the columns time_s, angle_rad and torque_Nm: a torque that alternates with periods of different length,
    well above the friction, while nobody holds the handle (docs/certificate.md).
    """

    recording: Positional[Path]
    """CSV file."""
    stiffness: Annotated[float | None, arg(metavar="N_M_PER_RAD")] = None
    """Stiffness to judge [N m/rad]; only the limit when left out."""
    damping: Annotated[float, arg(metavar="N_M_S_PER_RAD")] = 0.0
    """Damping of the spring [N m s/rad]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the identified axis and its limit; returns the exit code."""
        from palpate.base.arrays.checks import finite_or_none
        from palpate.devices.wrist import certify_wrist, load

        console = console_for(self.json)
        require_writable(self.json)
        found = certify_wrist(*load(self.recording), self.stiffness, self.damping)
        units = {"mass": ("inertia", "kg m^2"), "damping": ("damping", "N m s/rad"), "friction": ("friction", "N m"),
                 "delay": ("delay", "s")}  # fmt: skip
        for key, (name, unit) in units.items():
            low, high = found.spread(key)
            say(console, f"{low:.3g} to {high:.3g} {unit} in {len(found.fits)} parts of the recording", f"{name}:")
        for name in found.uncertain():
            say(console, f"{name} differs between the parts: record motions of different speed", "note:", "yellow")
        limit = f"stable below {found.k_max:.3g} N m/rad with {self.damping:g} N m s/rad"
        verdict = f"{self.stiffness:g} N m/rad is {found.verdict}; " if found.verdict else ""
        say(console, f"{verdict}{limit} (it would swing at {found.frequency:.3g} Hz)", "wrist:", "bold")
        fits = {name: list(found.spread(key)) for key, (name, _) in units.items()}
        write_json(self.json, {"rate_Hz": found.rate_Hz, "resolution_rad": found.resolution_rad, **fits,
                               "uncertain": found.uncertain(), "k_max_Nm_per_rad": finite_or_none(found.k_max),
                               "k_linear_Nm_per_rad": finite_or_none(found.k_linear),
                               "frequency_Hz": found.frequency, "verdict": found.verdict})  # fmt: skip
        return 0
