"""`palpate device bench`."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.base.errors import DeviceError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from palpate.cli.commands.device._guide import Guide
    from palpate.devices.accuracy import Accuracy
    from palpate.devices.bench import Bench
    from palpate.devices.driver import Driver
    from palpate.devices.identify import AxisFit
    from palpate.devices.judge import Check


@dataclass
class Command:
    """Measure a device, step by step: noise, resolution, rate, mass, friction, delay, force; write model and page.

    examples:
      palpate device bench simulated --yes --out device.yaml
      palpate device bench my_device:Omega --out omega.yaml --json omega.json
      palpate device bench my_device:Omega --weight 0.1 --page omega.html --like omega.3
      palpate device bench haply:rate=2000 --exchange 60
      palpate certify omega.yaml --stiffness 1000

    In a terminal it leads through the steps: the driver is tested, the device rests for a second, and is pushed to and
    fro along each axis by at most 0.5 N; its force is compared with a weight and a spring, if you have them, by a slow
    motion up and down, and the figures with those of the vendor. --yes asks nothing, and pushes (docs/device-bench.md).
    """

    name: Positional[str]
    """Driver: MODULE:CLASS, my_device.so (a driver in C), or a name of `palpate device list`."""
    out: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Write the device's model for `palpate certify`; in a terminal device.yaml when left out."""
    weight: Annotated[float | None, arg(metavar="KG")] = None
    """Compare the force with a weight that you hang on the handle when asked [kg]."""
    spring: Annotated[float | None, arg(metavar="N_PER_M")] = None
    """Compare the force with a spring along the vertical, fastened to the handle when asked [N/m]."""
    page: Annotated[Path | None, arg(metavar="FILE.html")] = None
    """Write a page with all figures, beside those that driver and vendor state; in a terminal device.html."""
    like: Annotated[str | None, arg(metavar="DEVICE")] = None
    """Compare with the published figures of a touch, touch-x, omega.3, sigma.7, falcon, inverse3 or minverse."""
    exchange: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Instead, without a push: time the messages with Haply's service beside a bare echo, and a session this long."""
    yes: bool = False
    """Push without asking."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the measurements as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the measurements and write the model; returns the exit code."""
        from palpate.cli.commands.device._guide import Guide
        from palpate.devices.bench import measure
        from palpate.devices.open import open_python_driver
        from palpate.devices.published import attributes_of, compare, published_of, stated_by

        console = console_for(self.json)
        for file in (self.out, self.json, self.page):
            require_writable(file)
        if self.like is not None:
            published_of(self.like)  # refuses an unknown name before a push
        if self.exchange is not None:
            from palpate.session.haply_exchange import measure_exchange

            times = measure_exchange(self.name, self.exchange)
            say(console, times.in_words(), "exchange:")
            write_json(self.json, times)
            return 0
        guide, driver = Guide(self.name, self.yes), open_python_driver(self.name, Path())
        checks = self._test(driver, guide, console)
        guide.rest()
        found = measure(driver, self.name, guide.push)
        _print(found, console)
        compared = self._force(driver, found, guide, console)
        like = guide.like(self.like)
        stated, published = stated_by(driver, found), [] if like is None else compare(published_of(like), driver, found)
        for row in (*stated, *published):
            say(console, row.in_words(), f"{row.name}:", "" if row.agrees else "yellow")
        if like is not None and not published:
            say(console, f"{published_of(like).source}; nothing to compare", f"{like}:")
        attributes = attributes_of(found)
        if attributes:
            words = ", ".join(f"{name} = {value:g}" for name, value in attributes.items())
            say(console, f"{words}: state them in the driver (docs/device.md)", "driver:")
        out, page = self._files(guide)
        if page is not None:
            from palpate.report.device import write_device_page

            say(console, str(write_device_page(page, found, compared, stated, published, checks)), "page:")
        if out is not None and self.out is None and not found.pushed:
            say(console, "none: it was not pushed, or did not move, so its mass and friction are unknown", "model:")
            out = None
        if out is not None:
            notes = {"device": self.name, "measured by": "palpate device bench", "driver": attributes}
            found.model().save(out, notes)
            say(console, f"{out}; judge it: palpate certify {out} --stiffness 400", "model:")
        model = str(out) if out else None
        more = {
            "attributes": attributes,
            "force": compared,
            "stated": stated,
            "like": like,
            "published": published,
            "checks": checks,
        }
        write_json(self.json, {**vars(found), "model": model, **more})
        return 0

    def _test(self, driver: Driver, guide: Guide, console: Console) -> list[Check]:
        """The checks of `palpate device test` without a push.

        Raises:
            DeviceError: numbers or axes are wrong, so that a push would measure nothing and might go anywhere.
        """
        from palpate.devices.judge import judge_driver

        guide.begin("driver", "numbers, axes, units and rate")
        checks = judge_driver(driver, self.name, push=False)
        wrong = [check for check in checks if not check.passed]
        for check in wrong:
            say(console, f"{check.value}; mend: {check.mend}", f"{check.name}:", "yellow")
        serious = [check.name for check in wrong if check.name != "rate"]
        if serious:
            what = f"{self.name} fails the test of a driver: {', '.join(serious)}"
            raise DeviceError(what, mend=f"correct it, and repeat palpate device test {self.name}")
        return checks

    def _files(self, guide: Guide) -> tuple[Path | None, Path | None]:
        """Files of the model and of the page: those of the options, and in a terminal usual ones."""
        return (
            self.out or (Path("device.yaml") if guide.asks else None),
            self.page or (Path("device.html") if guide.asks else None),
        )

    def _force(self, driver: Driver, found: Bench, guide: Guide, console: Console) -> list[Accuracy]:
        """The force of the device against a weight and a spring, where they are given.

        Where the guide asks, one that does not suit the device is told, and what was measured before is kept.
        """
        from palpate.devices.accuracy import UNITS, by_spring, by_weight
        from palpate.devices.driver import facts

        compared: list[Accuracy] = []
        if guide.asks and facts(driver, self.name).force_max == 0.0:
            say(console, "the device has no force: nothing to compare with a weight or a spring", "force:")
            return compared
        for by, option, judge, words in (
            ("weight", self.weight, by_weight, "the force on the handle by a weight of known mass"),
            ("spring", self.spring, by_spring, "the same by a spring of known stiffness"),
        ):
            given = guide.number(by, option, words, UNITS[by])
            if given is None:
                continue
            try:
                if found.axes[2].fit is None:  # a servo along an axis that does not obey goes anywhere
                    what = f"{self.name} was not pushed along z, or hardly moved, so nothing moves it up and down"
                    raise DeviceError(what, mend=f"palpate device test {self.name} says where its pushes go")
                compared.append(judge(driver, self.name, given, self._ask))
            except DeviceError as error:
                if not guide.asks:
                    raise
                say(console, f"not compared: {error}", "force:", "yellow")
                continue
            say(console, f"by the {by} of {given:g} {UNITS[by]}: {compared[-1].in_words()}", "force:")
        return compared

    def _ask(self, words: str) -> None:
        """Let the user prepare something; a simulated device needs nobody."""
        from palpate.devices.simulated import SimulatedDevice

        if self.name.partition(":")[0] == SimulatedDevice.name_of_driver:
            return
        if not sys.stdin.isatty():
            raise DeviceError(f"{words}: there is no terminal to ask in", mend="run it in a terminal")
        print(f"{words}, keep your hands off, and press Enter: ", end="", file=sys.stderr, flush=True)
        if not sys.stdin.readline():
            raise DeviceError(f"{words}: nobody answered", mend="press Enter when it is done")


def _print(found: Bench, console: Console) -> None:
    """Print what was measured without a weight or a spring."""
    console.print(_table(found))
    fresh = f"{100 * found.fresh:.0f} % of the readings are new"
    say(console, f"{found.rate_Hz:.0f} Hz, p99 of the interval {found.interval_p99_us:.0f} us, {fresh}", "rate:")
    if found.irregular:
        say(console, "readings came much later than others: end other programs and measure again", "note:", "yellow")
    if found.stopped:
        say(console, "the handle left a quarter of its workspace: a push ended early", "note:", "yellow")
    for doubt in found.doubts():
        say(console, doubt, "note:", "yellow")
    if found.pushed:
        limit, unsafe = found.limits()
        words = f"{limit:.0f} N/m without damping; {unsafe:.0f} N/m at the unsafe end of all intervals"
        say(console, words, "wall:")


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
