"""`palpate device bench`."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.console.output import console_for, require_writable, say, write_json
from palpate.errors import DeviceError

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.devices.accuracy import Accuracy
    from palpate.devices.bench import Bench
    from palpate.devices.driver import Driver
    from palpate.devices.identify import AxisFit

_UNITS = {"weight": "kg", "spring": "N/m"}


@dataclass
class Command:
    """Measure a device: noise, resolution, rate, mass, friction, delay; write the model that `certify` judges.

    examples:
      palpate device bench simulated --yes --out device.yaml
      palpate device bench my_device:Omega --out omega.yaml --json omega.json
      palpate device bench my_device:Omega --weight 0.1 --page omega.html
      palpate device bench haply:rate=2000 --exchange 60
      palpate certify omega.yaml --stiffness 1000

    The device rests for a second, and then moves to and fro along each axis, pushed by at most 0.5 N. With --weight or
    --spring its force is compared with a known one: it then moves slowly up and down, twice.
    """

    name: Positional[str]
    """Driver: MODULE:CLASS, my_device.so (a driver in C), or a name of `palpate device list`."""
    out: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Write the device's model for `palpate certify`."""
    weight: Annotated[float | None, arg(metavar="KG")] = None
    """Compare the force with a weight that you hang on the handle when asked [kg]."""
    spring: Annotated[float | None, arg(metavar="N_PER_M")] = None
    """Compare the force with a spring along the vertical, fastened to the handle when asked [N/m]."""
    page: Annotated[Path | None, arg(metavar="FILE.html")] = None
    """Write a page with all figures, beside those that the driver states."""
    exchange: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Instead, without a push: time the messages with Haply's service beside a bare echo, and a session this long."""
    yes: bool = False
    """Push without asking."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the measurements as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the measurements and write the model; returns the exit code."""
        from palpate.cli.device._common import require_consent
        from palpate.devices.bench import measure, stated_by
        from palpate.devices.open import open_python_driver

        console = console_for(self.json)
        for file in (self.out, self.json, self.page):
            require_writable(file)
        if self.exchange is not None:
            from palpate.devices.exchange import measure_exchange

            times = measure_exchange(self.name, self.exchange)
            say(console, times.in_words(), "exchange:")
            write_json(self.json, times)
            return 0
        driver = open_python_driver(self.name, Path())
        if getattr(driver, "force_max", 0.0) > 0.0:
            require_consent(self.yes, f"{self.name} will push with 0.5 N along each axis")
        found = measure(driver, self.name)
        console.print(_table(found))
        fresh = f"{100 * found.fresh:.0f} % of the readings are new"
        say(console, f"{found.rate_Hz:.0f} Hz, p99 of the interval {found.interval_p99_us:.0f} us, {fresh}", "rate:")
        if found.stopped:
            say(console, "the handle left a quarter of its workspace: a push ended early", "note:", "yellow")
        for doubt in found.doubts():
            say(console, doubt, "note:", "yellow")
        if any(axis.fit is not None for axis in found.axes):
            limit, unsafe = found.limits()
            say(
                console,
                f"{limit:.0f} N/m without damping; {unsafe:.0f} N/m at the unsafe end of all intervals",
                "wall:",
            )
        if self.out is not None:
            found.model().save(self.out, {"device": self.name, "measured by": "palpate device bench"})
            say(console, f"{self.out}; judge it: palpate certify {self.out} --stiffness 400", "model:")
        compared = self._compare(driver)
        for one in compared:
            say(console, f"by the {one.by} of {one.given:g} {_UNITS[one.by]}: {one.in_words()}", "force:")
        stated = stated_by(driver, found)
        for row in stated:
            say(console, row.in_words(), f"{row.name}:", "" if row.agrees else "yellow")
        if self.page is not None:
            from palpate.report.device import write_device_page

            say(console, str(write_device_page(self.page, found, compared, stated)), "page:")
        model = str(self.out) if self.out else None
        write_json(self.json, {**vars(found), "model": model, "force": compared, "stated": stated})
        return 0

    def _compare(self, driver: Driver) -> list[Accuracy]:
        """The force of the device against the weight and the spring that are given."""
        from palpate.devices.accuracy import by_spring, by_weight

        found = []
        for given, judge in ((self.weight, by_weight), (self.spring, by_spring)):
            if given is not None:
                found.append(judge(driver, self.name, given, self._ask))
        return found

    def _ask(self, words: str) -> None:
        """Let the user prepare something; a simulated device needs nobody."""
        from palpate.devices.simulated import SimulatedDevice

        if self.name.partition(":")[0] == SimulatedDevice.name_of_driver:
            return
        if not sys.stdin.isatty():
            raise DeviceError(f"{words}: there is no terminal to ask in", mend="run it in a terminal")
        print(f"{words}, keep your hands off, and press Enter: ", end="", file=sys.stderr, flush=True)
        sys.stdin.readline()


def _table(found: Bench) -> Table:
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    fitted = ("mass [kg]", "damping [N s/m]", "friction [N]", "spring [N/m]", "delay [ms]", "residual / noise [mN]")
    for column in ("axis", "noise [um]", "step [um]", *fitted):
        table.add_column(escape(column), justify="right")
    for axis in found.axes:
        step = "none seen" if axis.resolution_m is None else f"{1e6 * axis.resolution_m:.3g}"
        f = axis.fit
        table.add_row(axis.axis, f"{1e6 * axis.noise_m:.3g}", step, *(["-"] * len(fitted) if f is None else _cells(f)))
    return table


def _cells(f: AxisFit) -> list[str]:
    """Values with half widths of their 95 % intervals; the residual beside what noise explains."""

    def cell(name: str, unit: float = 1.0) -> str:
        reach = unit * f.student * getattr(f.deviations, name)
        return f"{unit * getattr(f, name):.3g} +-{reach:.1g}"

    values = [*(cell(name) for name in ("mass", "damping", "friction", "stiffness")), cell("delay", 1e3)]
    return [*values, f"{1e3 * f.residual:.2g} / {1e3 * f.noise:.2g}"]
