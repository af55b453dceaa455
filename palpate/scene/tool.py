"""Contact spheres of the tool, in addition to the sphere on the tip."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from pydantic import Field

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.errors import SceneError
from palpate.base.values import Positive, Section, Vector

TIP = "tip"


class ToolSphereSection(Section):
    """A contact sphere fixed to a link of the tool."""

    link: str = TIP
    """link of the follower, or tip: frame T, with z along the jaws; a PSM has shaft, wrist, tool, jaw_1 and jaw_2"""
    at: Vector = (0.0, 0.0, 0.0)
    """centre in the frame of the link; for a jaw, in the closed position [m]"""
    radius: Annotated[Positive, Field(le=0.1)]
    """radius [m]"""


@dataclass(frozen=True)
class LinkSphere:
    """A contact sphere with its name and the core's representation."""

    name: str  #: name of the link and, if a link has several spheres, a number: shaft 3
    link: str | None  #: link of the follower that carries the sphere; None: the tool tip T
    core: _core.ToolSphere

    def centre(self, X_WT: Array, X_WB: Array, links: dict[str, Array], jaw: float) -> Array:
        """Centre (3,) in W [m]; links: X_Blink (`Arm.link_poses`); jaw: opening angle [rad]."""
        X = X_WT if self.link is None else X_WB @ links[self.link]
        return np.asarray(X[:3, :3] @ self.core.centre(jaw) + X[:3, 3])


def tool_sphere(follower: Arm, sphere: ToolSphereSection) -> LinkSphere:
    """The contact sphere on a link of the follower.

    Raises:
        SceneError: the arm does not have the link.
    """
    at, names = np.array(sphere.at), list(follower.link_names)
    joint = follower.drawn_joint(sphere.link)
    if joint is not None and joint.parent in names:  # a jaw: it rotates on its parent link
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
    """The spheres of the arm's model if `whole`, followed by the spheres of the scene.

    Raises:
        SceneError: a link is unknown, or there are too many spheres.
    """
    from_model = [ToolSphereSection.model_validate(s) for s in follower.spheres] if whole else []
    if whole and not from_model:
        raise SceneError(
            "contact.whole_tool: the spheres of this tool are not known",
            why=f"the model of {follower.name} has no entry spheres",
            mend="list them yourself: contact.spheres",
        )
    most = _core.MAX_SPHERES - 1
    if len(from_model) + len(listed) > most:
        raise SceneError(
            f"contact.spheres: {len(from_model) + len(listed)} spheres in addition to the one on the tip are too many",
            why=f"{len(from_model)} belong to the whole tool" if from_model else "",
            mend=f"use at most {most}" + ("; or leave whole_tool out" if from_model else ""),
        )
    places = Counter(s.link for s in [*from_model, *listed])
    count: Counter[str] = Counter()
    spheres = []
    for s in [*from_model, *listed]:
        count[s.link] += 1
        name = f"{s.link} {count[s.link]}" if places[s.link] > 1 or s.link == TIP else s.link
        spheres.append(replace(tool_sphere(follower, s), name=name))
    return spheres
