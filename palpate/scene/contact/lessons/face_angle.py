"""The paper's section 3.3 in the plane: the angle of a mesh face from the motion of one contact point.

A circle, the spherical proxy region (SPR), moves along +x. Its lowest point is ``depth`` below the previous face,
y = 0. At the origin that face meets the next face, which is turned by phi_f: up for phi_f > 0 (a concave edge), down
for phi_f < 0 (a convex edge). The solid is below. The reported contact point c is where the circle meets the
face ahead,

    c = x + r (cos phi_n, sin phi_n),    phi_n = phi_f - asin(d / r),    c_y = c_x tan phi_f        (Figs 10, 11)

with d the height of the centre x above the next face. From one c to the next:

    phi_f = atan2(delta c_y, delta c_x)                                                              (Eq 18)
    n_f . v_c = 0                                       two candidates                               (Eq 19)
    n_f . x_n >= 0                                      of which x_n, the last good normal, picks    (Eq 20)

Source: Munawar and Fischer 2016, as read in docs/geometry.md. Angles in radians unless a name says degrees.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array

#: Failure of Eq 20 at a concave edge that overhangs the tool.
OVERHANG = "sharp concave edge: the normal points into the wall"


@dataclass(frozen=True)
class Slide:
    """A circle that slides along +x toward the next face.

    Raises:
        ValueError: the circle never meets the next face at this depth or angle.
    """

    phi_f: float  #: angle of the next face, -pi < phi_f < pi, not 0
    radius: float = 15e-3  #: radius of the circle [m]
    depth: float = 5e-3  #: depth of its lowest point below the previous face [m]

    def __post_init__(self) -> None:
        if not 0.0 < self.depth < 2.0 * self.radius:
            raise ValueError(f"depth must be between 0 and two radii, got {self.depth} m of {self.radius} m")
        if not 0.0 < abs(self.phi_f) < np.pi:
            raise ValueError(f"phi_f must be between -180 and 180 degrees and not 0, got {np.degrees(self.phi_f):g}")

    @property
    def height(self) -> float:
        """Height of the centre above the previous face [m]."""
        return self.radius - self.depth

    @property
    def face(self) -> Array:
        """Direction of the next face (2,), away from the edge."""
        return np.array([np.cos(self.phi_f), np.sin(self.phi_f)])

    @property
    def normal(self) -> Array:
        """True outward normal of the next face (2,)."""
        return np.array([-np.sin(self.phi_f), np.cos(self.phi_f)])

    def travel(self, n: int) -> Array:
        """Positions x of the centre (n,) [m] at which the circle meets the next face, without both ends.

        The first end is where the circle reaches the edge, or a steep face above it. The last end is where it is
        entirely inside the face (concave) or loses contact (convex).
        """
        run, rise = self.face
        first = -float(np.sqrt(self.radius**2 - self.height**2))
        touch = (self.height * run - self.radius) / rise  # where d = r
        if rise > 0 and touch * run + self.height * rise > 0:
            first = touch
        last = (self.height * run + np.copysign(self.radius, rise)) / rise
        return np.asarray(np.linspace(first, last, n + 2)[1:-1])

    def centre(self, x: Array) -> Array:
        """Positions of the centre (n, 2) [m]."""
        return np.stack([x, np.full_like(x, self.height)], axis=1)

    def phi_n(self, x: Array) -> Array:
        """Angle of the contact point on the circumference (n,), from +x [rad]."""
        return np.asarray(self.phi_f - np.arcsin(self.centre(x) @ self.normal / self.radius))

    def contact(self, x: Array) -> Array:
        """Contact point c (n, 2) [m], at the angle phi_n on the circle."""
        angle = self.phi_n(x)
        return np.asarray(self.centre(x) + self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))

    def rate(self, x: Array) -> Array:
        """Derivative dc/dx (n, 2) [-]: motion of the centre plus motion around the circle."""
        angle = self.phi_n(x)
        turn = np.sin(self.phi_f) / np.cos(angle - self.phi_f)  # r dphi_n/dx
        around = turn[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        return np.asarray(np.array([1.0, 0.0]) + around)


def face_angle(c_before: npt.ArrayLike, c_now: npt.ArrayLike, baseline: float = 0.0) -> float:
    """Eq 18: phi_f = atan2(delta c_y, delta c_x) of two contact points (2,) [m].

    If the circle is deep in the solid, the point may move backwards along the face. The result is then phi_f + 180
    degrees: the same line, so Eqs 19 and 20 give the same normal.

    Raises:
        ValueError: the points are closer than ``baseline`` [m], so that noise would dominate.
    """
    dx, dy = np.asarray(c_now, dtype=float) - np.asarray(c_before, dtype=float)
    moved = float(np.hypot(dx, dy))
    if moved == 0.0 or moved < baseline:
        raise ValueError(
            f"the contact point moved {1e6 * moved:.3g} um, less than the baseline of {1e6 * baseline:g} um"
        )
    return float(np.arctan2(dy, dx))


def candidates(phi_f: float) -> tuple[Array, Array]:
    """Eq 19: both unit normals (2,) of a face at phi_f, the left one first."""
    left = np.array([-np.sin(phi_f), np.cos(phi_f)])
    return left, -left


def locally_convex(normals: tuple[Array, Array], x_n: npt.ArrayLike) -> Array:
    """Eq 20: the normal with n . x_n >= 0, where x_n is the last valid normal (2,)."""
    return normals[0] if float(normals[0] @ np.asarray(x_n, dtype=float)) >= 0.0 else normals[1]


def eq20(slide: Slide) -> tuple[Array, str]:
    """Normal by Eqs 18-20 on the next face if the previous normal was correct, and the failure in words (or empty).

    A circle that moves along the previous face only meets convex edges below a right angle, where Eq 20 holds. At a
    concave edge above a right angle, Eq 20 chooses the normal that points into the wall.
    """
    x = slide.travel(3)
    c = slide.contact(x)
    n = locally_convex(candidates(face_angle(c[0], c[1])), [0.0, 1.0])
    return n, "" if n @ slide.normal > 0 else OVERHANG


def angle_noise(noise: float, speed: float = 0.02, rate: float = 250.0, draws: int = 200_000, seed: int = 0) -> float:
    """Eq 18 under noise: RMS error of phi_f [deg] from two noisy points one tick apart.

    Args:
        noise: standard deviation of each coordinate of a contact point [m].
        speed: speed of the contact point along the face [m/s].
        rate: rate of the collision reports [Hz].
        draws: number of simulated pairs of points.
        seed: seed of the noise.
    """
    points = noise * np.random.default_rng(seed).normal(size=(2, draws, 2))
    delta = points[1] - points[0] + [speed / rate, 0.0]
    return float(np.degrees(np.sqrt((np.arctan2(delta[:, 1], delta[:, 0]) ** 2).mean())))


def contact_normal_error(radius: float, depth: float) -> float:
    """Fig 9B: angle [deg] between the face's normal and the line from contact to centre, for contacts on the surface.

    The circle intersects the face at two points; from each the centre lies acos((r - depth) / r) off the normal.
    """
    return float(np.degrees(np.arccos((radius - depth) / radius)))
