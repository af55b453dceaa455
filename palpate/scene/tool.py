"""The spheres of the tool beside the one on its tip."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from pydantic import Field

from palpate import _core
from palpate.arm import Arm
from palpate.arrays import Array
from palpate.errors import SceneError
from palpate.values import Positive, Section, Vector

TIP = "tip"


class ToolSphereSection(Section):
    """A sphere that is fixed to the tool."""

    link: str = TIP
    """a link of the follower, or tip: the frame T, z along the jaws; a PSM has shaft, wrist, tool, jaw_1 and jaw_2"""
    at: Vector = (0.0, 0.0, 0.0)
    """its centre, in that link's frame; of a jaw: when it is closed [m]"""
    radius: Annotated[Positive, Field(le=0.1)]
    """of the sphere [m]"""


@dataclass(frozen=True)
class LinkSphere:
    """A sphere of the tool, for people and for the core."""

    name: str  #: the link it sits on and, where there are several, its number: shaft 3
    link: str | None  #: of the follower that carries it; None: the tool tip T
    core: _core.ToolSphere

    def centre(self, X_WT: Array, X_WB: Array, links: dict[str, Array], jaw: float) -> Array:
        """(3,) its centre in W [m]; links: X_Blink (`Arm.link_poses`); jaw: how far it is open [rad]."""
        X = X_WT if self.link is None else X_WB @ links[self.link]
        return np.asarray(X[:3, :3] @ self.core.centre(jaw) + X[:3, 3])


def tool_sphere(follower: Arm, sphere: ToolSphereSection) -> LinkSphere:
    """A sphere on a link of an arm.

    Raises:
        SceneError: the arm has no such link.
    """
    at, names = np.array(sphere.at), list(follower.link_names)
    joint = follower.drawn_joint(sphere.link)
    if joint is not None and joint.parent in names:  # a jaw: it turns on the link that carries it
        R, p = joint.X_parent[:3, :3], joint.X_parent[:3, 3]
        turn = joint.multiplier * R @ joint.axis
        core = _core.ToolSphere(R @ at + p, sphere.radius, names.index(joint.parent), np.ascontiguousarray(p), turn)
        return LinkSphere(sphere.link, joint.parent, core)
    if sphere.link in names:
        return LinkSphere(sphere.link, sphere.link, _core.ToolSphere(at, sphere.radius, names.index(sphere.link)))
    if sphere.link == TIP:
        return LinkSphere(TIP, None, _core.ToolSphere(at, sphere.radius))
    raise SceneError(
        f"there is no link {sphere.link!r} for a sphere of the tool",
        where="contact.spheres",
        why=f"the follower is {follower.name}",
        mend=f"its links: {', '.join(dict.fromkeys([TIP, *names]))}",
    )


def tool_spheres(follower: Arm, listed: Sequence[ToolSphereSection], whole: bool) -> list[LinkSphere]:
    """Those of the arm's model when the whole tool is asked for, then those of the scene.

    Raises:
        SceneError: an unknown link, or more spheres than a tool may have.
    """
    own = [ToolSphereSection.model_validate(s) for s in follower.spheres] if whole else []
    if whole and not own:
        raise SceneError(
            "contact.whole_tool: the spheres of this tool are not known",
            why=f"the model of {follower.name} has no entry spheres",
            mend="list them yourself: contact.spheres",
        )
    most = _core.MAX_SPHERES - 1
    if len(own) + len(listed) > most:
        raise SceneError(
            f"contact.spheres: {len(own) + len(listed)} spheres beside the one on the tip are too many",
            why=f"{len(own)} are the whole tool's" if own else "",
            mend=f"at most {most}" + ("; or leave whole_tool out" if own else ""),
        )
    places = Counter(s.link for s in [*own, *listed])
    count: Counter[str] = Counter()
    spheres = []
    for s in [*own, *listed]:
        count[s.link] += 1
        name = f"{s.link} {count[s.link]}" if places[s.link] > 1 or s.link == TIP else s.link
        spheres.append(replace(tool_sphere(follower, s), name=name))
    return spheres
