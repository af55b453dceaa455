"""A record as a pandas table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError
from palpate.record.ticks import Signal, Ticks

if TYPE_CHECKING:
    import pandas as pd


def column_names(signal: Signal) -> list[str]:
    """Names of a signal's columns with their unit: ``F_T_W.x [N]``, ``q_L.1 [rad|m]``, ``depth [m]``."""
    unit = f" [{signal.unit}]" if signal.unit not in ("", "1", "bits") else ""
    if signal.size == 1:
        return [signal.name + unit]
    parts = {3: "xyz", 4: "wxyz"}.get(signal.size, "") if signal.frame or signal.name.startswith("quat") else ""
    names = list(parts) if parts else [str(i + 1) for i in range(signal.size)]
    return [f"{signal.name}.{part}{unit}" for part in names]


def to_pandas(ticks: Ticks, signals: dict[str, Signal]) -> pd.DataFrame:
    """A table with one row per tick, the time [s] as index, and a column for each number of each signal.

    Raises:
        MissingExtraError: pandas is not installed.
    """
    try:
        import pandas as pd
    except ImportError:
        raise MissingExtraError("pandas", "pandas") from None
    columns: dict[str, Array] = {}
    for name, signal in signals.items():
        values = ticks[name].reshape(len(ticks), math.prod(ticks[name].shape[1:]))
        if name != "t":
            columns |= dict(zip(column_names(signal), values.T, strict=True))
    return pd.DataFrame(columns, index=pd.Index(ticks["t"], name="t [s]"))
