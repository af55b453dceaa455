from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tyro.conf import Positional

from palpate import Record


@dataclass
class Command:
    """Print the largest contact force of a record."""

    record: Positional[Path]

    def __call__(self) -> int:
        print(f"{np.linalg.norm(Record.open(self.record)['F_T_W'], axis=1).max():.2f} N")
        return 0
