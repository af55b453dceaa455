"""Section ``remote``: a follower that is felt across a network (docs/network.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from palpate.base.values import Positive, Section, Vector

UNKNOWN = "unknown surface"
"""Name of the plane that is felt where a scene has no object; its number is that of the objects."""


class RemoteSection(Section):
    """The other end of a link, and the simulated site that ``palpate serve follower`` runs."""

    mode: Literal["model", "passivity", "direct"] = "model"
    """what the hand feels: a local model; the measured force, as far as both ports' energies allow; or all of it"""
    rate: Annotated[float, Field(ge=50.0, le=1000.0)] = 1000.0
    """packets per second in each direction [Hz]"""
    together: bool = False
    """true: palpate run starts the follower's end and a relay on this machine as well"""
    network: str = "none"
    """network that this relay emulates, by name, or a measured trace: FILE.csv, FILE.pcap"""
    site_shift: Vector = (0.0, 0.0, 0.0)
    """where the objects of the simulated site are, less where this scene has them, in W [m]"""
    site_stiffness: Positive | None = None
    """stiffness of the objects of the simulated site; as in this scene when left out [N/m]"""
    planes: bool = False
    """true: what the tool touches where this scene has no object is felt as a plane, which the site estimates"""
    hidden: tuple[str, ...] = ()
    """objects that the simulated site alone has: the hand knows nothing of them"""
