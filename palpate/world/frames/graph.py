"""The graph of frames: a tree that places every frame once, and checks that compare second paths with it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array, rigid
from palpate.base.errors import FrameError
from palpate.world.frames.edge import Edge

WORLD = "world"


@dataclass(frozen=True)
class FramePose:
    """Pose of a frame in another, along the edges between them."""

    X: Array
    """X_reference_frame (4, 4) [m]"""
    covariance: Array
    """covariance (6, 6) of ``[dp; dtheta]`` in the reference frame, of first order [m, rad]"""
    path: tuple[str, ...]
    """frames from the reference to the frame"""
    stamp: float | None
    """time of the oldest stamped measurement on the path, seconds since 1970; None if no edge has a stamp"""

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the position, root mean square of the axes [m]."""
        return math.sqrt(max(float(np.trace(self.covariance[:3, :3])), 0.0) / 3.0)

    @property
    def sigma_rad(self) -> float:
        """Standard deviation of the orientation, root mean square of the axes [rad]."""
        return math.sqrt(max(float(np.trace(self.covariance[3:, 3:])), 0.0) / 3.0)


@dataclass(frozen=True)
class Disagreement:
    """A second path to a frame, compared with the first."""

    edge: Edge
    """the second path: an edge with ``check``"""
    path: tuple[str, ...]
    """frames of the first path, from the edge's parent to its child"""
    xi: Array
    """displacement (6,) from the first path's pose to the second's, in the edge's parent [m, rad]"""
    mahalanobis: float
    """size of the displacement in standard deviations; infinite where both paths claim to be exact [-]"""
    probability: float
    """probability of a larger displacement if both covariances are right: chi-squared with 6 degrees of freedom [-]"""
    p_holm: float
    """the same, corrected for all second paths of the graph as one family (Holm) [-]"""

    @property
    def distance_m(self) -> float:
        """Distance between the two origins [m]."""
        return float(np.linalg.norm(self.xi[:3]))

    @property
    def angle_rad(self) -> float:
        """Angle between the two orientations [rad]."""
        return float(np.linalg.norm(self.xi[3:]))


class FrameGraph:
    """Frames and the poses between them.

        graph = FrameGraph([Edge("world", "camera", X_WC, source="camera.yaml"), Edge("camera", "anatomy", X_CA)])
        graph.pose("anatomy", "world").X

    Every frame but the root has one edge to its parent, so that its pose is unique. An edge with ``check`` states a
    second pose of a frame; `disagreements` compares it with the first.

    Args:
        edges: edges in any order.
        root: name of the frame without a parent.

    Raises:
        FrameError: a frame has two parents, a parent is unknown, or frames form a circle. The message names them.
    """

    def __init__(self, edges: Iterable[Edge] = (), root: str = WORLD) -> None:
        self.root = root
        self._edges: dict[str, Edge] = {}
        self._checks: list[Edge] = []
        waiting = list(edges)
        self._require_parents(waiting)
        for edge in sorted(waiting, key=lambda edge: edge.check):
            self._require_free(edge)
            if edge.check:
                self._checks.append(edge)
            else:
                self._edges[edge.child] = edge
        self._require_tree()

    def add(self, edge: Edge) -> None:
        """Add a frame, or a second path to a frame.

        Raises:
            FrameError: the child is placed already, or the parent is unknown; nothing has changed.
        """
        self._require_parents([edge])
        self._require_free(edge)
        if edge.check:
            self._checks.append(edge)
        else:
            self._edges[edge.child] = edge

    def update(self, child: str, X: npt.ArrayLike, stamp: float, covariance: npt.ArrayLike | None = None) -> None:
        """Set the pose of a live frame in its parent.

        Args:
            child: name of the frame.
            X: X_parent_child (4, 4) [m].
            stamp: time of the measurement, seconds since 1970; later than the present one.
            covariance: covariance (6, 6) [m, rad]; unchanged when None.

        Raises:
            FrameError: the frame is not live, the pose is invalid, or the stamp does not advance; nothing has changed.
        """
        edge = self.edge(child)
        if edge.kind != "live":
            raise FrameError(f"frame {child!r} is {edge.kind}, not live", mend="only live frames move during a session")
        if edge.stamp is not None and stamp <= edge.stamp:
            back = f"stamp {stamp:.6f} s is not later than the present {edge.stamp:.6f} s"
            raise FrameError(f"frame {child!r}: {back}", why="the source repeats a pose, or its clock was set back")
        C = edge.covariance if covariance is None else np.asarray(covariance)
        self._edges[child] = replace(edge, X=np.asarray(X), covariance=C, stamp=stamp)

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of all frames, the root first and parents before their children."""
        return tuple(sorted((self.root, *self._edges), key=lambda name: len(self._up(name))))

    @property
    def edges(self) -> tuple[Edge, ...]:
        """Edges of the tree, in the order of `frames`."""
        return tuple(self._edges[name] for name in self.frames[1:])

    def __contains__(self, name: object) -> bool:
        return name == self.root or name in self._edges

    def edge(self, child: str) -> Edge:
        """The edge that places a frame.

        Raises:
            FrameError: there is no such frame, or it is the root.
        """
        self._require_known(child)
        if child == self.root:
            raise FrameError(f"frame {child!r} is the root and has no parent")
        return self._edges[child]

    def is_live(self, name: str) -> bool:
        """True if the pose of a frame in the root can change while a session runs."""
        self._require_known(name)
        return any(edge.kind == "live" for edge in self._up(name))

    def pose(self, of: str, in_: str | None = None) -> FramePose:
        """Pose of a frame in another; in the root when `in_` is left out.

        The covariance is propagated along the path with independent edges, of first order in their errors (Barfoot and
        Furgale, IEEE T-RO 30(3), 2014).

        Raises:
            FrameError: there is no such frame; the message lists the known ones.
        """
        reference = self.root if in_ is None else in_
        self._require_known(of, reference)
        down, up = self._up(of), self._up(reference)
        while down and up and down[-1] is up[-1]:  # the common ancestors
            down.pop(), up.pop()
        X_CF, C_CF = _composed(down)
        X_CR, C_CR = _composed(up)
        X_RC, C_RC = rigid.inverse(X_CR), rigid.inverse_covariance(X_CR, C_CR)
        covariance = rigid.composed_covariance(X_RC, C_RC, X_CF, C_CF)
        path = (reference, *(edge.parent for edge in up), *(edge.child for edge in reversed(down)))
        stamps = [edge.stamp for edge in (*up, *down) if edge.stamp is not None]
        return FramePose(X_RC @ X_CF, 0.5 * (covariance + covariance.T), path, min(stamps, default=None))

    def path(self, of: str) -> list[Edge]:
        """Edges from the root down to a frame.

        Raises:
            FrameError: there is no such frame.
        """
        self._require_known(of)
        return self._up(of)[::-1]

    def disagreements(self) -> list[Disagreement]:
        """Each second path to a frame, compared with the first, in the order given."""
        found = [self._disagreement(edge) for edge in self._checks]
        if not found:
            return []
        from palpate.base.arrays.intervals import holm  # few scenes have second paths

        corrected = holm(np.array([one.probability for one in found]))
        return [replace(one, p_holm=float(p)) for one, p in zip(found, corrected, strict=True)]

    def _disagreement(self, edge: Edge) -> Disagreement:
        from scipy.special import chdtrc

        first = self.pose(edge.child, edge.parent)
        xi = rigid.displacement(first.X, edge.X)
        d = mahalanobis(xi, first.covariance + edge.covariance)
        p = float(chdtrc(6, d * d))
        return Disagreement(edge, first.path, xi, d, p, p)

    def _up(self, name: str) -> list[Edge]:
        """Edges from a frame up to the root."""
        found = []
        while name != self.root:
            found.append(self._edges[name])
            name = found[-1].parent
        return found

    def _require_known(self, *names: str) -> None:
        for name in names:
            if name not in self:
                raise FrameError(f"there is no frame {name!r}", mend=_nearest(name, self.frames))

    def _require_free(self, edge: Edge) -> None:
        if edge.check:
            return
        if edge.child == self.root:
            raise FrameError(f"frame {edge.child!r} is the root and cannot have a parent", mend="rename the child")
        if edge.child in self._edges:
            first = self._edges[edge.child]
            what = f"frame {edge.child!r} is placed twice: in {first.parent!r} and in {edge.parent!r}"
            raise FrameError(what, mend="give each frame its own name, or check: true to compare the two paths")

    def _require_parents(self, edges: list[Edge]) -> None:
        known = {self.root, *self._edges, *(edge.child for edge in edges if not edge.check)}
        for edge in edges:
            needed = (edge.parent, edge.child) if edge.check else (edge.parent,)
            for name in needed:
                if name not in known:
                    word = "parent" if name == edge.parent else "frame"
                    what = f"frame {edge.child!r}: there is no {word} {name!r}"
                    raise FrameError(what, mend=_nearest(name, sorted(known)))

    def _require_tree(self) -> None:
        for name in self._edges:
            chain = [name]
            while chain[-1] != self.root:
                chain.append(self._edges[chain[-1]].parent)
                if chain[-1] == name:
                    what = f"frames form a circle: {' > '.join(reversed(chain))}"
                    raise FrameError(what, mend=f"one of them must lead to {self.root!r}, or give check: true")
                if len(chain) > len(self._edges) + 1:
                    break  # a circle above this frame; the frames in it report it


def _composed(up: list[Edge]) -> tuple[Array, Array]:
    """Pose and covariance along edges that are listed from the child up."""
    X, C = np.eye(4), np.zeros((6, 6))
    for edge in reversed(up):
        X, C = X @ edge.X, rigid.composed_covariance(X, C, edge.X, edge.covariance)
    return X, C


def mahalanobis(xi: Array, covariance: Array) -> float:
    """Size of a displacement (6,) in standard deviations; infinite along a direction without variance [-]."""
    variance, axes = np.linalg.eigh(1e6 * covariance)  # in mm and mrad, for the limits below
    along = 1e3 * axes.T @ xi
    free = variance > 1e-12
    if np.abs(along[~free]).max(initial=0.0) > 1e-6:
        return math.inf
    return float(np.sqrt(np.sum(along[free] ** 2 / variance[free])))


def _nearest(name: str, names: Iterable[str]) -> str:
    known = list(names)
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"frames: {', '.join(known)}"
