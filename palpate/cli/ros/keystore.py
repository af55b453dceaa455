"""`palpate ros keystore`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from palpate.console.output import console_for, say


@dataclass
class Command:
    """Create keys for DDS security (SROS 2) with openssl, and print the variables that enable it.

    examples:
      palpate ros keystore keys /palpate/sim /palpate/haptics
    """

    folder: Positional[Path]
    """Folder of the keystore; existing keys stay."""
    enclaves: Positional[tuple[str, ...]]
    """Enclave names, one for each process, e.g. /palpate/haptics."""

    def __call__(self) -> int:
        """Create the keystore and print its enclaves and variables."""
        from palpate.ros import keystore

        console = console_for(None)
        for place in keystore.make(self.folder, self.enclaves):
            say(console, f"made {place}")
        for name, value in keystore.environment(self.folder, self.enclaves[0] if self.enclaves else "/NAME").items():
            say(console, f"export {name}={value}")
        return 0
