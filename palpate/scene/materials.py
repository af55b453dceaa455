"""Materials, regions and motions of the core, made from the sections of an object."""

from __future__ import annotations

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.scene.model import ObjectSection
from palpate.scene.tissue import RegionSection


def material(thing: ObjectSection, region: RegionSection | None = None) -> _core.Material:
    """The material of an object, or of one of its regions: values that the region leaves out are the object's."""
    K, B, mu, held = (
        value if region is None or value_there is None else value_there
        for value, value_there in (
            (getattr(thing, key), getattr(region, key, None))
            for key in ("stiffness", "damping", "friction", "static_friction")
        )
    )
    return _core.Material(np.array(K), np.array(B), mu, held or 0.0)


def regions(thing: ObjectSection) -> list[_core.Region]:
    """The regions of an object."""
    return [_core.Region(np.array(r.at), r.half, r.radius, r.blend, material(thing, r)) for r in thing.regions]


def motion(thing: ObjectSection, middle: Array) -> _core.Motion:
    """The motion of an object; it turns about `middle` (3,), in W [m]."""
    terms = thing.motion
    waves = [
        _core.Wave(np.array(m.amplitude), np.radians(m.turn_deg), m.period, float(np.radians(m.phase_deg)))
        for m in terms
        if any(m.amplitude) or any(m.turn_deg)
    ]
    steady, spin = (
        np.sum([getattr(m, key) for m in terms] or [np.zeros(3)], axis=0) for key in ("velocity", "spin_deg")
    )
    return _core.Motion(steady, np.radians(spin), waves, middle)
