"""`palpate soak`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.console.output import console_for, require_writable, say, write_json
from palpate.errors import PalpateError

if TYPE_CHECKING:
    from palpate.verify.soak import Soak

LINES = 50  # progress lines over the whole run


@dataclass
class Command:
    """Poke random meshes millions of times, or step random hands through palpate.Haptics, and count what went wrong.

    examples:
      palpate soak contact
      palpate soak contact --passes 100000 --seed 7
      palpate soak contact --passes 2000 --method penalty
      palpate soak device --seconds 60
    """

    what: Positional[Literal["contact", "device"]]
    """contact: the path of the proxy is checked against every triangle; device: caps and zero force on wrong input."""
    seconds: float = 60.0
    """device: time of each of four loops, 500 to 4000 Hz, as fast as the machine allows [s]."""
    passes: int = 10_000_000
    """Number of pokes, each of about 60 ticks [-]."""
    method: str = "proxy"
    """Contact method; `penalty`, which has no memory, shows how a tool pops through."""
    seed: int = 1
    """Seed; the same seed gives the same meshes and pokes [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the count as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Poke or step, print the count, write the JSON contract. Returns 1 if anything went wrong."""
        if self.what == "device":
            return self._device()
        from palpate.verify.soak import run, table

        console = console_for(self.json)
        require_writable(self.json)
        lines = 0

        def progress(so_far: Soak) -> None:
            nonlocal lines
            if so_far.passes * LINES >= lines * self.passes:
                lines += 1
                say(console, f"{so_far.passes:,} passes, {so_far.popped:,} popped through, {so_far.seconds:.0f} s")

        try:
            done = run(self.passes, self.method, self.seed, progress)
        except ValueError as error:
            raise PalpateError(str(error)) from error
        console.print(table(done))
        write_json(self.json, done)
        return 1 if done.popped else 0

    def _device(self) -> int:
        from palpate.verify.soak_device import run

        console = console_for(self.json)
        require_writable(self.json)
        if not 0.0 < self.seconds <= 86_400.0:
            raise PalpateError(f"--seconds {self.seconds:g}: must be above 0 and at most a day", mend="--seconds 60")
        done = run(self.seconds, self.seed, lambda rate: say(console, f"loop of {rate:g} Hz"))
        say(console, f"{done.steps:,} steps, {done.pressed:,} with a force, {done.wrong:,} with wrong input")
        caps = f"{done.above_cap} above the cap, {done.above_rate_cap} above the rate cap"
        say(console, f"{done.not_finite} wrenches not finite, {caps}, {done.force_on_wrong_input} on wrong input")
        write_json(self.json, done)
        return 1 if done.bad else 0
