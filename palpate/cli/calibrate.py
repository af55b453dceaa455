"""`palpate calibrate NAME`: the commands and their options; the work is in `palpate/calibrate`."""

from __future__ import annotations

#: A calibration is a dataclass here and its name in this table.
COMMANDS: dict[str, type] = {}
