"""`palpate bench network`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, write_json


@dataclass
class Command:
    """Measure a session across a network beside one without: missed ticks, processor time, packets of strangers.

    examples:
      palpate bench network
      palpate bench network --seconds 60 --flood 20000 --json network.json
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json/bench-network.md); - for the standard output."""
    seconds: float = 20.0
    """Duration of each of four runs [s]."""
    flood: float = 5000.0
    """Forged packets per second in the fourth run [Hz]."""
    network: str = "netfi-delay-2"
    """What the relay between both ends does (docs/network.md)."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.session.network import network
        from palpate.session.network.keys import require_cryptography
        from palpate_lab.verify.bench import network as bench

        if not 1.0 <= self.seconds <= 3600.0:
            raise PalpateError(f"--seconds {self.seconds:g}: must be from 1 to 3600 s", mend="e.g. --seconds 20")
        if not 0.0 <= self.flood <= 1e6:
            raise PalpateError(f"--flood {self.flood:g}: must be from 0 to 1e6 Hz", mend="e.g. --flood 5000")
        require_cryptography()
        network(self.network)
        console = console_for(self.json)
        require_writable(self.json)
        figures = bench.run(self.seconds, self.flood, self.network)
        console.print(bench.table(figures))
        write_json(self.json, figures)
        return 0
