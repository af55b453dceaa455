"""Converts the sections of an object to the core's materials, regions and motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.scene.model import ObjectSection
from palpate.scene.tissue import MotionSection, RegionSection


def material(obj: ObjectSection, region: RegionSection | None = None) -> _core.Material:
    """The material of an object, or of one of its regions. Values that a region leaves out are those of the object."""
    K, B, mu, mu_static = (
        value if region is None or region_value is None else region_value
        for value, region_value in (
            (getattr(obj, key), getattr(region, key, None))
            for key in ("stiffness", "damping", "friction", "static_friction")
        )
    )
    return _core.Material(np.array(K), np.array(B), mu, mu_static or 0.0)


def regions(obj: ObjectSection) -> list[_core.Region]:
    """The regions of an object."""
    return [_core.Region(np.array(r.at), r.half, r.radius, r.blend, material(obj, r)) for r in obj.regions]


def motion(obj: ObjectSection, middle: Array) -> _core.Motion:
    """The motion of an object; `middle` (3,) is its centre of rotation in W [m]."""
    return summed(obj.motion, middle)


def summed(terms: Sequence[MotionSection], middle: Array) -> _core.Motion:
    """The sum of motions; `middle` (3,) is the centre of rotation [m]."""
    waves = [
        _core.Wave(np.array(m.amplitude), np.radians(m.turn_deg), m.period, float(np.radians(m.phase_deg)))
        for m in terms
        if any(m.amplitude) or any(m.turn_deg)
    ]
    steady, spin = (
        np.sum([getattr(m, key) for m in terms] or [np.zeros(3)], axis=0) for key in ("velocity", "spin_deg")
    )
    return _core.Motion(steady, np.radians(spin), waves, middle)
