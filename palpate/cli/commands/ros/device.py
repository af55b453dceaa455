"""`palpate ros device`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Offer a haptic device as a CRTK master: its pose goes out, forces come in, a stale force is zero.

    examples:
      palpate ros device haply
      palpate ros device simulated --arm MTML --duration 10
      palpate ros device my_device:Omega --arm MTMR --network

    Topics: measured_cp, setpoint_cp, measured_cv, gripper/measured_js, buttons and operating_state out; servo_cf,
    body/servo_cf, body/set_cf_orientation_absolute, state_command, hold and free in; each button also by its name in
    CRTK, such as A, B and C of a Haply. Forces are capped at those of the driver, and zero 30 ms after the last one.
    """

    name: Positional[str]
    """Driver: MODULE:CLASS, my_device.so (a driver in C), or a name of `palpate device list`."""
    arm: str = "MTMR"
    """Name of the arm on the network, the first part of its topics."""
    duration: Annotated[float | None, arg(metavar="SECONDS")] = None
    """End after this time [s]; without it, Ctrl-C ends it."""
    network: bool = False
    """Communicate with other machines; otherwise only within this one."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write what was done as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Serve the device; returns 1 if it failed."""
        from palpate.devices.open import open_python_driver
        from palpate.ros.device_master import serve

        if not self.arm.isidentifier():
            raise PalpateError(f"--arm {self.arm}: is no name of an arm", mend="letters, digits and _, e.g. MTMR")
        console = console_for(self.json)
        require_writable(self.json)
        driver = open_python_driver(self.name, Path())
        say(console, f"{self.name} is /{self.arm}; Ctrl-C ends it")
        done = serve(self.name, driver, self.arm, self.network, self.duration)
        rounds = f"{done.rounds:,} rounds at {done.rate_Hz:.0f} of {driver.rate:.0f} Hz"
        peaks = f"at most {done.peak_force_N:.3g} N, {done.peak_50ms_N:.3g} N over 50 ms"
        say(console, f"{rounds}, {done.forces:,} forces, {peaks}; {done.stale} went stale")
        if done.fault:
            say(console, f"{done.fault}; the force was set to zero", "fault:", "red")
        write_json(self.json, done)
        return int(bool(done.fault))
