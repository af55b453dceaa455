"""`palpate ros keystore`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from palpate.console.output import console_for, say


@dataclass
class Command:
    """Keys for DDS security (SROS 2), by openssl alone; says how to use them.

    examples:
      palpate ros keystore keys /palpate/sim /palpate/haptics
    """

    folder: Positional[Path]
    """Of the keystore; what is there stays."""
    enclaves: Positional[tuple[str, ...]]
    """Names, one for each process, e.g. /palpate/haptics."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.ros import keystore

        console = console_for(None)
        for place in keystore.make(self.folder, self.enclaves):
            say(console, f"made {place}")
        for name, value in keystore.environment(self.folder, self.enclaves[0] if self.enclaves else "/NAME").items():
            say(console, f"export {name}={value}")
        return 0
