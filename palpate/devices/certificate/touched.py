"""What a certificate of a scene judges: objects and regions, alone, at once, or by the whole tool, and fixtures."""

from __future__ import annotations

from dataclasses import dataclass, replace

from palpate.devices.certificate.at_once import groups
from palpate.devices.certificate.guidance import NO_OBJECT, fixture_springs
from palpate.devices.certificate.spheres import longest
from palpate.scene import fixtures
from palpate.scene.gains import touched_stiffness
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene

PATH_FRACTIONS = (0.3, 0.6)
"""Fractions of the operator's path, analysed in addition to the start."""


@dataclass(frozen=True)
class Touched:
    """An object, region or fixture of a scene with one stiffness."""

    name: str
    index: int
    """Index of the object; negative for a fixture."""
    K: float
    """Stiffness along the stiffest axis [N/m]."""
    B: float
    """Damping along the least damped axis [N s/m]."""
    B_most: float
    """Damping along the most damped axis; a large damping can also destabilise the loop [N s/m]."""
    others: tuple[int, ...] = ()
    """Indices of the other objects that are touched at the same time."""
    several: bool = False
    """True if several spheres of the tool touch at once; K and B are those of each contact."""


def touched(rig: Rig) -> list[Touched]:
    """Objects, their regions with own parameters, objects that the tool can touch at once, and guidance fixtures.

    A tool of several spheres has a second row for each surface, which several of its spheres touch at once. The rows
    are in the order of the certificates.
    """
    each = [_alone(rig.scene, i) for i in range(len(rig.scene.objects))]
    found = [one for parts in each for one in parts]
    for group in groups(rig, longest(rig, PATH_FRACTIONS)):
        stiffest = [max(each[i], key=lambda part: part.K) for i in group]
        K, B = sum(one.K for one in stiffest), sum(min(part.B for part in each[i]) for i in group)
        most = sum(max(part.B_most for part in each[i]) for i in group)
        found.append(Touched(" and ".join(one.name for one in stiffest) + " at once", group[0], K, B, most, group[1:]))
    if rig.spheres:
        found += [replace(one, name=f"{one.name}, whole tool", several=True) for one in found]
    return found + [Touched(f.name, NO_OBJECT, f.K, f.B, f.B) for f in fixture_springs(fixtures.each(rig.fixtures))]


def _alone(scene: Scene, i: int) -> list[Touched]:
    """An object and its regions."""
    surface = scene.objects[i]
    found = [Touched(surface.name, i, touched_stiffness(scene, i), min(surface.damping), max(surface.damping))]
    for region in surface.regions:
        K, B = region.stiffness or surface.stiffness, region.damping or surface.damping
        found.append(Touched(f"{surface.name}, {region.name}", i, max(K), min(B), max(B)))
    return found
