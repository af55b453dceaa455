"""Pose along a chain of three measured frames with lever arms of half a metre, beside a second measured path."""

from __future__ import annotations

import itertools

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import exp, inverse, log, rigid
from palpate.world.frames import Edge, FrameGraph
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "frames"
FORMS = {
    RIGHT: "three frames of 0.3 mm and 3 mrad; a second path",
    "narrow": "errors three times as large as stated",
    "moved": "the last frame moves by 15 mm before the second path is measured",
    "inverse": "the middle frame is given the other way round",
}
_NAMES = ("world", "tracker", "marker", "camera")
_SIGMA = np.array([3e-4] * 3 + [3e-3] * 3)  # m, rad
_SURE = 0.01  # probability below which the command calls two paths a disagreement


def _measured(X: Array, factor: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """A pose X (4, 4) with an error of a random correlated covariance, and that covariance (6, 6)."""
    L = np.diag(_SIGMA) @ (np.eye(6) + 0.3 * rng.normal(size=(6, 6)))
    e = factor * L @ rng.normal(size=6)
    return rigid(exp(e[3:]) @ X[:3, :3], X[:3, 3] + e[:3]), L @ L.T


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One graph; the pose of the last frame in the world is judged."""
    factor, graph, true = 3.0 if form == "narrow" else 1.0, FrameGraph(), np.eye(4)
    for k, (parent, child) in enumerate(itertools.pairwise(_NAMES)):
        X = rigid(exp(rng.normal(size=3)), rng.normal(0.0, 0.3, 3))
        true = true @ X
        given, C = _measured(X, factor, rng)
        if form == "inverse" and k == 1:
            given = inverse(given)
        graph.add(Edge(parent, child, given, C, kind="measured"))
    moved = true.copy()
    moved[:3, 3] += exp(rng.normal(size=3))[:, 0] * (15e-3 if form == "moved" else 0.0)
    X, C = _measured(moved, factor, rng)
    graph.add(Edge("world", "camera", X, C, kind="measured", check=True))
    found = graph.pose("camera")
    error = np.r_[moved[:3, 3] - found.X[:3, 3], log(moved[:3, :3] @ found.X[:3, :3].T)]
    told = any(one.p_holm < _SURE for one in graph.disagreements())
    return of_ellipsoid(error, found.covariance, told)
