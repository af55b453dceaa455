"""Checks the numbers of a command's options: finite, not below zero, and ports that exist."""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass
from typing import Any

from palpate.base.errors import PalpateError

_SIGNED = {"threshold", "end"}  # options whose value may be below zero, such as Hounsfield units of a CT
_ZERO = {"noise", "smooth", "start", "damping", "seed", "hole", "port", "openigtlink", "fle"}
"""Options for which zero has a meaning; so it has where zero is the default."""
_PORTS = {"port", "openigtlink"}
_UNITS = {"MM": "mm", "SECONDS": "s", "HZ": "Hz", "N_PER_M": "N/m", "N_S_PER_M": "N s/m", "N/M": "N/m",
          "N_M_PER_RAD": "N m/rad", "N_M_S_PER_RAD": "N m s/rad"}  # fmt: skip
_SECONDS = {"duration", "seconds", "timeout", "interval"}


def check_numbers(command: Any) -> None:
    """Refuse numbers that no option can mean, by the name of the option.

    Raises:
        PalpateError: a number is not finite, is negative, is zero where zero has no meaning, or is no port.
    """
    if not is_dataclass(command):
        return
    for field in fields(command):
        value = getattr(command, field.name)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and value != field.default:
            _check(field.name, value, field.default, _unit(command, field.name))


def _check(name: str, value: float, default: object, unit: str) -> None:
    option = f"--{name.replace('_', '-')} {value:g}" if isinstance(value, float) else f"--{name} {value}"
    if name in _PORTS:
        if not 0 <= value <= 65535:
            what = f"{option}: a port is a number from 1 to 65535, or 0 for a free one"
            raise PalpateError(what.replace("_", "-"), mend=f"give e.g. --{name} 18944")
        return
    usual = f"--{name.replace('_', '-')} {default:g}" if isinstance(default, (int, float)) and default else ""
    mend = f"give e.g. {usual}" if usual else "give another number, or leave the option out"
    zero = name in _ZERO or default == 0
    if name not in _SIGNED and not (value > 0.0 or (zero and value == 0.0)):
        if isinstance(value, int):
            limit = f"a whole number from {0 if zero else 1}"
        else:
            limit = ("0 or more" if zero else "above 0") + (unit and " " + unit)
        raise PalpateError(f"{option}: must be {limit}", mend=mend)
    if not math.isfinite(value):
        raise PalpateError(f"{option}: must be a finite number", mend=mend)


def _unit(command: Any, name: str) -> str:
    """Unit of an option by its metavar; seconds by its name."""
    for kind in type(command).__mro__:
        hint = getattr(kind, "__annotations__", {}).get(name)
        for more in getattr(hint, "__metadata__", ()):
            metavar = getattr(more, "metavar", None)
            if metavar in _UNITS:
                return _UNITS[metavar]
    return "s" if name in _SECONDS else ""
