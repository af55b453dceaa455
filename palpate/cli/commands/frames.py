"""`palpate frames`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say, write_json

if TYPE_CHECKING:
    from palpate.world.frames import Disagreement, Edge, FrameGraph, FramePose


@dataclass
class Command:
    """Print the tree of frames of a scene: each pose with its source, age and uncertainty; and paths that disagree.

    examples:
      palpate frames scenes/tracked.yaml
      palpate frames my.yaml --of anatomy --reference camera
    """

    scene: Positional[Path]
    """Scene file (YAML)."""
    of: Annotated[str | None, arg(metavar="FRAME")] = None
    """Also print the pose of this frame."""
    reference: Annotated[str, arg(metavar="FRAME")] = "world"
    """Frame in which --of is printed."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the frames as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the frames; returns the exit code."""
        from palpate.scene import Scene
        from palpate.scene.rig import build

        console, now = console_for(self.json), time.time()
        scene = Scene.load(self.scene)
        graph = build(scene).frames
        for line in _tree(graph, now):
            say(console, line)
        for found in graph.disagreements():
            say(console, _compared(found), "disagreement:" if found.p_holm < 0.01 else "two paths:",
                "yellow" if found.p_holm < 0.01 else "")  # fmt: skip
        asked = None if self.of is None else graph.pose(self.of, self.reference)
        if asked is not None:
            say(console, f"{self.of} in {self.reference}, by {' > '.join(asked.path)}: "
                         f"{_sigmas(asked.sigma_m, asked.sigma_rad)}")  # fmt: skip
            for row in asked.X:
                say(console, "  " + " ".join(f"{x:12.6f}" for x in row))
        write_json(self.json, {"scene": str(self.scene), "frames": [_values(graph, edge, now) for edge in graph.edges],
                               "disagreements": [_disagreement(found) for found in graph.disagreements()],
                               "pose": None if asked is None else _asked(asked)})  # fmt: skip
        return 0


def _tree(graph: FrameGraph, now: float) -> Iterator[str]:
    """One line per frame, children indented below their parents."""
    children: dict[str, list[Edge]] = {}
    for edge in graph.edges:
        children.setdefault(edge.parent, []).append(edge)
    rows: list[tuple[str, str]] = [(graph.root, "")]

    def visit(name: str, depth: int) -> None:
        for edge in children.get(name, ()):
            rows.append((f"{'  ' * depth}{edge.child}", _words(graph, edge, now)))
            visit(edge.child, depth + 1)

    visit(graph.root, 1)
    width = max(len(name) for name, _ in rows) + 2
    for name, words in rows:
        yield f"{name:<{width}}{words}".rstrip()


def _words(graph: FrameGraph, edge: Edge, now: float) -> str:
    parts = [edge.kind, edge.source or "no source"]
    age = edge.age(now)
    if age is not None:
        parts.append(_age(age))
    found = graph.pose(edge.child)
    if edge.kind != "known" or found.sigma_m > 0.0 or found.sigma_rad > 0.0:
        parts.append(f"in {graph.root} {_sigmas(found.sigma_m, found.sigma_rad)}")
    if edge.fre_m is not None:
        parts.append(f"FRE {1e3 * edge.fre_m:.2f} mm")
    if edge.tre_m is not None:
        parts.append(f"TRE {1e3 * edge.tre_m:.2f} mm")
    return ", ".join(parts)


def _sigmas(sigma_m: float, sigma_rad: float) -> str:
    return f"\N{PLUS-MINUS SIGN}{1e3 * sigma_m:.2f} mm \N{PLUS-MINUS SIGN}{math.degrees(sigma_rad):.2f} deg"


def _age(seconds: float) -> str:
    if seconds < 0.0:
        return "stamped in the future"
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit} old"
    return f"{seconds:.0f} s old"


def _compared(found: Disagreement) -> str:
    edge = found.edge
    if math.isfinite(found.mahalanobis):
        size = f"{found.mahalanobis:.1f} standard deviations, probability {found.probability:.2g}"
    else:
        size = "both claim to be exact"
    return (
        f"{edge.child} by {' > '.join(found.path)} and directly in {edge.parent} ({edge.source or 'no source'}) "
        f"differ by {1e3 * found.distance_m:.2f} mm and {math.degrees(found.angle_rad):.2f} deg: {size}"
    )


def _values(graph: FrameGraph, edge: Edge, now: float) -> dict[str, Any]:
    found = graph.pose(edge.child)
    return {
        "frame": edge.child, "parent": edge.parent, "kind": edge.kind, "source": edge.source, "age_s": edge.age(now),
        "X_parent_frame": edge.X, "covariance": edge.covariance, "X_world_frame": found.X,
        "sigma_world_m": found.sigma_m, "sigma_world_rad": found.sigma_rad, "fre_m": edge.fre_m, "tre_m": edge.tre_m,
    }  # fmt: skip


def _asked(found: FramePose) -> dict[str, Any]:
    return {"path": found.path, "X_reference_frame": found.X, "covariance": found.covariance,
            "sigma_m": found.sigma_m, "sigma_rad": found.sigma_rad}  # fmt: skip


def _disagreement(found: Disagreement) -> dict[str, Any]:
    from palpate.base.arrays.checks import finite_or_none

    return {
        "frame": found.edge.child, "parent": found.edge.parent, "path": found.path, "source": found.edge.source,
        "distance_m": found.distance_m, "angle_rad": found.angle_rad,
        "mahalanobis": finite_or_none(found.mahalanobis), "probability": found.probability,
        "p_holm": found.p_holm,
    }  # fmt: skip
