"""Presets: named sets of values. Keys given in the scene file take precedence."""

from __future__ import annotations

import copy
from typing import Any

from palpate.base.arrays.plain import Content

#: `paper`: Munawar and Fischer 2016. SPR of 30 mm diameter (Fig 12), 500 Hz (section 2.4), Table 1's stable middle row.
#: `as-shipped`: the authors' published code of the time: haptics at 100 Hz without damping, collision at 250 Hz.
PRESETS: dict[str, Content] = {
    "paper": {
        "contact": {"radius": 0.015},
        "rates": {"haptic": 500.0},
        "torque": {"mode": "paper"},
        "objects": {"stiffness": 400.0, "damping": 5.0},
    },
    "as-shipped": {
        "contact": {"method": "paper-alg1", "radius": 0.015, "collision_rate": 250.0},
        "rates": {"haptic": 100.0},
        "torque": {"mode": "paper"},
        "objects": {"stiffness": 400.0, "damping": 0.0},
        "stability": {"passivity": "off"},
    },
}


def apply(data: Any) -> Any:
    """Fill in the values of the preset for keys that the scene leaves out."""
    name = data.get("preset") if isinstance(data, dict) else None
    preset = PRESETS.get(name) if isinstance(name, str) else None
    if preset is None:
        return data
    out = copy.copy(data)
    for section, values in preset.items():
        given = out.get(section, {})
        if section == "objects":
            if isinstance(given, (list, tuple)):
                out[section] = [{**values, **o} if isinstance(o, dict) else o for o in given]
        elif isinstance(given, dict):
            out[section] = {**values, **given}
    return out
