"""`palpate device test`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Test a driver: numbers, axes, units, rate, and the direction of a push of 0.5 N. Exits with 1 if a check fails.

    examples:
      palpate device test simulated --yes
      palpate device test my_device:Omega
      palpate device test my_device:Omega --no-push
    """

    name: Positional[str]
    """Driver: MODULE:CLASS, my_device.so (a driver in C), or a name of `palpate device list`."""
    yes: bool = False
    """Push without asking."""
    no_push: bool = False
    """Do not push: check readings and rate only."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the checks as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print one line per check; returns the exit code."""
        from palpate.cli.commands.device._common import require_consent
        from palpate.devices.judge import judge_driver
        from palpate.devices.open import open_python_driver

        console = console_for(self.json)
        require_writable(self.json)
        driver = open_python_driver(self.name, Path())
        if not self.no_push and getattr(driver, "force_max", 0.0) > 0.0:
            require_consent(self.yes, f"{self.name} will push with 0.5 N along each axis")
        checks = judge_driver(driver, self.name, not self.no_push)
        for check in checks:
            text = check.value if check.passed else f"{check.value}; mend: {check.mend}"
            say(console, text, f"{'ok  ' if check.passed else 'FAIL'} {check.name}:", "" if check.passed else "red")
        passed = all(check.passed for check in checks)
        write_json(self.json, {"driver": self.name, "passed": passed, "checks": checks})
        return 0 if passed else 1
