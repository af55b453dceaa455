"""`palpate keys`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg


@dataclass
class Command:
    """Make the key that both ends of a link share; copy the file to the other machine (docs/network.md).

    examples:
      palpate keys
      palpate keys --out link.key
    """

    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """File of the key; default: ~/.config/palpate/remote.key."""

    def __call__(self) -> int:
        """Write the key; returns the exit code."""
        from palpate.session.network.keys import default_path, make_key

        path = self.out or default_path()
        make_key(path)
        print(f"{path}: a new key; copy this file to the other machine, and show it to nobody")
        return 0
