"""Units in text: ``2 mm``, ``400 N/m`` or ``0.5 N s/m``, converted to the unit of a key."""

from __future__ import annotations

import math
import re
from fractions import Fraction

#: Length units of files, in metres.
FILE_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}

#: Length units of text in scene files, in metres.
LENGTHS = {"um": 1e-6, **FILE_UNITS}

_Size = tuple[float, tuple[int, int, int, int]]  # in SI units; exponents of m, kg, s, rad

#: Size of each unit. An angle counts as a dimension, so that N m and N m/rad differ.
_UNITS: dict[str, _Size] = {
    **{name: (size, (1, 0, 0, 0)) for name, size in LENGTHS.items()},
    **{name: (size, (0, 1, 0, 0)) for name, size in {"kg": 1.0, "g": 1e-3}.items()},
    **{name: (size, (0, 0, 1, 0)) for name, size in {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}.items()},
    **{name: (size, (0, 0, 0, 1)) for name, size in {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0}.items()},
    **{name: (size, (0, 0, -1, 0)) for name, size in {"Hz": 1.0, "kHz": 1e3}.items()},
    **{name: (size, (1, 1, -2, 0)) for name, size in {"N": 1.0, "mN": 1e-3, "kN": 1e3}.items()},
    **{name: (size, (2, 1, -2, 0)) for name, size in {"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "Nm": 1.0}.items()},
    **{name: (size, (-1, 1, -2, 0)) for name, size in {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}.items()},
    "Nmm": (1e-3, (2, 1, -2, 0)),
    "Ns": (1.0, (1, 1, -1, 0)),
}  # fmt: skip

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z°µ].*?)\s*")
_FACTOR = re.compile(r"([a-zA-Z]+)(?:\^?(\d))?")


def convert(text: str, unit: str) -> float | None:
    """The number of a text such as ``2 mm`` in another unit, e.g. 0.002 for ``m``; None if the text is no such number.

    Args:
        text: a number and its unit. Products are written with a space, ``*`` or ``.``, and quotients with ``/``.
        unit: the unit of the result; ``rad, m`` accepts both kinds.
    """
    match = _NUMBER.fullmatch(text)
    given = match and _size(match[2])
    if not match or given is None:
        return None
    for target in unit.split(","):
        wanted = _size(target)
        if wanted is not None and wanted[1] == given[1]:
            return _scaled(match[1], given[0], wanted[0])
    return None


def has_unit(text: str) -> bool:
    """Whether a text is a number followed by letters, of a known unit or not."""
    return _NUMBER.fullmatch(text) is not None


def examples(unit: str) -> str:
    """Other ways to write a unit, for messages: ``um, mm, cm, m, in``; the unit itself if it has no other name."""
    target = _size(unit.split(",")[0])
    names = [name for name, (_, dimension) in _UNITS.items() if target is not None and dimension == target[1]]
    return ", ".join(names) or unit


def is_known(unit: str) -> bool:
    """Whether text with a unit can be converted to this unit."""
    return all(_size(part) is not None for part in unit.split(","))


def _size(unit: str) -> _Size | None:
    size, exponents = 1.0, [0, 0, 0, 0]
    for i, side in enumerate(unit.replace("°", "deg").replace("µ", "u").split("/")):
        sign = -1 if i else 1
        for factor in re.split(r"[\s*.·]+", side.strip(" ()")):
            match = _FACTOR.fullmatch(factor)
            if match is None or match[1] not in _UNITS:
                return None
            power = sign * int(match[2] or 1)
            size *= _UNITS[match[1]][0] ** power
            exponents = [a + power * b for a, b in zip(exponents, _UNITS[match[1]][1], strict=True)]
    return size, (exponents[0], exponents[1], exponents[2], exponents[3])


def _scaled(number: str, size: float, target: float) -> float:
    """The decimal number times size / target, rounded once: 3 mm is the float 0.003."""
    value = float(number)
    if value == 0.0 or math.isinf(value):  # also keeps 1e999999999 out of exact arithmetic
        return value
    try:
        return float(Fraction(number) * Fraction(repr(size / target)))
    except OverflowError:
        return math.copysign(math.inf, value)
