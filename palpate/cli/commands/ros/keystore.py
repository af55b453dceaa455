"""`palpate ros keystore`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Create keys for DDS security (SROS 2) with openssl, and print the variables that enable it.

    examples:
      palpate ros keystore keys /palpate/sim /palpate/haptics /palpate/camera
      palpate ros keystore keys /lab/left=camera

    The last part of a name is its role, which decides what the key may publish and hear: haptics, sim, robot, camera,
    move, watch (hears alone), all. Another name takes a role by NAME=ROLE.
    """

    folder: Positional[Path]
    """Folder of the keystore; existing keys stay."""
    enclaves: Positional[tuple[str, ...]]
    """Enclave names, one for each process, e.g. /palpate/haptics, or NAME=ROLE."""
    authority: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder of the authority's key, which no machine needs that only uses a key; FOLDER-authority when left out."""

    def __call__(self) -> int:
        """Create the keystore and print its enclaves and variables."""
        from palpate.ros import keystore

        console = console_for(None)
        for place in keystore.make(self.folder, self.enclaves, self.authority):
            say(console, f"made {place}")
        first = self.enclaves[0].partition("=")[0] if self.enclaves else "/NAME"
        for name, value in keystore.environment(self.folder, first).items():
            say(console, f"export {name}={value}")
        return 0
