"""The procedure that registers an organ: a first pose, then touches where they help most, until the targets are met."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse, transform
from palpate.base.errors import RegistrationError
from palpate.world.registration import disagreement, organ_motion, predict, views
from palpate.world.registration.fiducials import points
from palpate.world.registration.touches import Guess, Touched, TouchRegistration, next_touch, touched_by, touches

CONFIDENCE = 0.95
"""Probability with which no target's error exceeds the stated accuracy."""
_MISSES = 0.5 * (1.0 - CONFIDENCE)  # half of what is allowed: predicted covariances are right within a quarter only
_APART = 8e-3  # smallest distance between two touched places [m]
_OUTSIDE = 5e-3  # largest distance of a target from the organ [m]
_FEWEST = 6  # touches before the accuracy can be met: fewer cannot contradict a wrong first pose
_PATCH, _FLAT = 5e-3, 0.97  # radius of a patch [m], length of its mean normal above which it can be touched


@dataclass(frozen=True)
class Organ:
    """The scan of an organ in its own frame O."""

    surface: _core.Surface
    points: Array  #: (M, 3) spread evenly over the surface [m]
    targets: Mapping[str, Array]  #: places (3,) at which the error counts, by name [m]

    def check_targets(self) -> None:
        """Check that all targets lie in the organ, or within 5 mm of it.

        Raises:
            RegistrationError: one does not; the message says so if mirrored targets all would.
        """
        self._require_near("target", self.targets, lambda d: d)

    def check_landmarks(self, landmarks: Mapping[str, Array]) -> None:
        """Check that landmarks (3,) lie within 5 mm of the surface [m].

        Raises:
            RegistrationError: one does not; the message says so if mirrored landmarks all would.
        """
        self._require_near("landmark", landmarks, np.abs)

    def _require_near(self, kind: str, places: Mapping[str, Array], size: Callable[[Array], Array]) -> None:
        p = np.array(list(places.values())).reshape(-1, 3)
        off = size(self._height(p))
        if not (off > _OUTSIDE).any():
            return
        worst = int(np.argmax(off))
        flipped = zip("xyz", 1.0 - 2.0 * np.eye(3), strict=True)
        mirrored = [axis for axis, flip in flipped if (size(self._height(p * flip)) <= _OUTSIDE).all()]
        why = f"with the opposite sign of {mirrored[0]} all {kind}s fit: the list is mirrored" if mirrored else ""
        where = "outside of the organ" if kind == "target" else "from the organ's surface"
        raise RegistrationError(
            f"{kind} {list(places)[worst]!r} lies {1e3 * off[worst]:.1f} mm {where}",
            why=why,
            mend=f"give {kind}s in metres, in the axes of the organ's own file",
        )

    def _height(self, p: Array) -> Array:
        return np.asarray(self.surface.nearest(np.ascontiguousarray(p))[0])

    @cached_property
    def touchable(self) -> tuple[Array, Array]:
        """Places (C, 3) whose neighbourhood is nearly flat [m], with their outward normals (C, 3)."""
        from scipy.spatial import cKDTree

        p = self.points[::10]
        normals = np.asarray(self.surface.nearest(np.ascontiguousarray(p))[2])
        near = cKDTree(p).query_ball_point(p, _PATCH)
        mean = np.array([normals[rows].mean(axis=0) for rows in near])
        flat = np.linalg.norm(mean, axis=1) > _FLAT
        return p[flat], normals[flat]


def from_landmarks(organ: Organ, landmarks: Mapping[str, Array], touched: Touched, sigma: float) -> Guess:
    """First pose X_WO from touched landmarks.

    Args:
        organ: the organ.
        landmarks: places (3,) on the surface in O, by name [m].
        touched: the touches, in the same order.
        sigma: standard deviation with which a landmark is found, on each axis [m].

    Raises:
        RegistrationError: the landmarks are degenerate, mirrored, or one of them is wrong.
    """
    p_O = np.array(list(landmarks.values()))
    normals = organ.surface.nearest(np.ascontiguousarray(p_O))[2]
    names = list(landmarks)
    found = points(
        p_O + touched.radius * normals, touched.p_WT, fle=np.full(3, np.hypot(sigma, touched.sigma)), names=names
    )
    wrong = [f"{names[i]!r} ({1e3 * found.residuals[i]:.1f} mm)" for i in found.outliers]
    if wrong or found.warnings:
        why = f"wrong landmark: {', '.join(wrong)}" if wrong else found.warnings[0]
        raise RegistrationError(
            "the touched landmarks disagree", why=why, mend="touch them again in the order asked for"
        )
    shift = np.diag([touched.tip**2] * 3 + [0.0] * 3)
    return Guess(found.X, found.covariance + shift)


@dataclass
class Procedure:
    """A running registration: the first pose, the touches so far, and what they predict at the targets."""

    organ: Organ
    first: Guess
    accuracy: float  #: error that no target may exceed with a probability of 95 % [m]
    sigma: float  #: standard deviation of a touch [m]
    tip: float  #: standard deviation of the tip's offset on each axis [m]
    radius: float  #: of the sphere on the tip [m]
    motion: float = np.inf
    """Motion of the organ half-way through the touches that they shall tell nine times of ten [m]"""
    view: Guess | None = None  #: pose X_CO in the view before the touches, if a view after them follows
    X_WT: list[Array] = field(default_factory=list)  #: poses (4, 4) of the tool in all touches

    def __post_init__(self) -> None:
        self.faults: tuple[str, ...] = ()  #: why the touches cannot be trusted
        self._skipped: list[Array] = []  # places in O where the tool felt nothing
        self._update()

    def add(self, X_WT: Array) -> None:
        """Take in a touch: pose (4, 4) of the tool whose tip touches [m]."""
        self.X_WT.append(X_WT)
        self._update()

    def remove(self) -> None:
        """Forget the last touch."""
        self.X_WT.pop()
        self._update()

    def look_again(self, view: Array) -> None:
        """Compare the camera's view (N, 3) after the touches with the one before; raises as `views.require_rest`."""
        if self.view is not None:
            views.require_rest(self.organ.points, self.view, view, next(iter(self.organ.targets.values())))

    def foreseen(self, most: int) -> Procedure | None:
        """This procedure after the touches that it will ask for, each on the predicted surface; None beyond `most`."""
        state = replace(self, X_WT=list(self.X_WT))
        while not state.met:
            if len(state.X_WT) == most:
                return None
            p_W, n_W = state.next_place()
            X = np.eye(4)
            X[:3, 3] = p_W + self.radius * n_W
            state.add(X)
        return state

    def skip(self, p_W: Array) -> None:
        """Propose no place near p_W (3,) any more [m]."""
        self._skipped.append(transform(inverse(self.found.X), p_W[None])[0])

    def _update(self) -> None:
        touched = touched_by(self.X_WT, self.radius, self.sigma, self.tip)
        self.found: TouchRegistration = touches(self.organ.surface, self.first, touched)
        self.faults = disagreement.reasons(self.organ.surface, self.first, touched, self.found)
        if self.met:  # a single test, when nothing else keeps the session from its end
            self.faults = organ_motion.told(self.organ.surface, self.first, touched, self.found)

    @property
    def targets(self) -> dict[str, predict.Target]:
        """Predicted error of each target."""
        return {name: self.found.target(p) for name, p in self.organ.targets.items()}

    @property
    def bounds(self) -> dict[str, float]:
        """Error that each target does not exceed; that none does has a probability of 95 % or more [m]."""
        each = 1.0 - _MISSES / len(self.organ.targets)
        return {name: predict.within(one.covariance, each) for name, one in self.targets.items()}

    @property
    def smallest_motion(self) -> float:
        """Smallest motion of the organ half-way through the touches that is told in nine of ten cases [m], or NaN."""
        touched = touched_by(self.X_WT, self.radius, self.sigma, self.tip)
        return organ_motion.smallest(self.organ.surface, self.first, touched, self.found)

    @property
    def smallest_motion_seen(self) -> float:
        """Smallest motion between two views that is told in nine of ten cases [m]; NaN without views."""
        return float("nan") if self.view is None else views.smallest(self.view)

    @property
    def met(self) -> bool:
        """True if the accuracy is met, nothing contradicts it, and motions of the asked size would have been told."""
        enough = not self.faults and len(self.X_WT) >= _FEWEST and max(self.bounds.values()) <= self.accuracy
        return enough and (self.motion == np.inf or self.smallest_motion <= self.motion)

    def require_sound(self, most: int) -> None:
        """Check that the touches agree, and that more of them are allowed.

        Raises:
            RegistrationError: they disagree, or `most` touches were not enough.
        """
        if self.faults:
            raise RegistrationError(
                "the touches disagree with the first pose or with each other",
                why="; ".join(self.faults),
                mend="fix what moved, calibrate the tip (palpate register pivot), and begin again",
            )
        if len(self.X_WT) >= most:
            worst = max(self.bounds, key=lambda name: self.bounds[name])
            what = f"{worst!r} is known within {1e3 * self.bounds[worst]:.2f} mm"
            if self.bounds[worst] <= self.accuracy:
                size = 1e3 * self.smallest_motion
                what = f"they tell a motion of the organ from {size:.2f} mm on, not from {1e3 * self.motion:g} mm on"
            raise RegistrationError(
                f"{most} touches are not enough: {what}",
                mend="state a larger accuracy, allow more touches, or reach places on other sides of the organ",
            )

    def next_place(self, reaches: Callable[[Array, Array], bool] | None = None) -> tuple[Array, Array]:
        """Place (3,) in W [m] whose touch lowers the largest target error most, and the surface's normal (3,) there.

        reaches: returns True for a place and normal in W that the tool can touch; default: all places.

        Raises:
            RegistrationError: no place is left.
        """
        p_O, n_O = self.organ.touchable
        X = self.found.X
        touched = transform(inverse(X), np.array([one[:3, 3] for one in self.X_WT]).reshape(-1, 3))
        taken = np.concatenate([touched, np.array(self._skipped).reshape(-1, 3)])
        if len(taken):
            apart = np.linalg.norm(p_O[:, None] - taken[None], axis=2).min(axis=1) > _APART
            p_O, n_O = p_O[apart], n_O[apart]
        goals = np.array(list(self.organ.targets.values()))
        while len(p_O):
            best, _ = next_touch(self.found, goals, p_O, n_O, self.sigma)
            p_W, n_W = transform(X, p_O[best : best + 1])[0], X[:3, :3] @ n_O[best]
            if reaches is None or reaches(p_W, n_W):
                return p_W, n_W
            p_O, n_O = np.delete(p_O, best, axis=0), np.delete(n_O, best, axis=0)
        raise RegistrationError(
            "no place is left that the tool can touch", mend="move the arm, or state a lower accuracy"
        )


def nothing_felt(misses: int) -> RegistrationError:
    """The error of a tool that feels nothing where the surface is predicted."""
    return RegistrationError(
        f"nothing is felt at {misses} places where the surface is predicted",
        why="the organ or the camera has moved, the tip is calibrated wrongly, or the scan is of another organ",
        mend="check them, and begin again",
    )
