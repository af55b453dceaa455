"""The angle of a mesh face from the motion of one contact point: the paper's section 3.3 in numbers.

A circle, the tool's sphere seen from the side, slides along a face toward the next one. A collision library reports
only the point where its outline cuts the mesh. You learn

* why the line from this point to the circle's centre is not a surface normal once the circle is pressed in (Fig 9);
* that the point moves exactly at the angle of the face at any depth (Fig 11, Eq 18), without noise;
* that the paper picks one of two candidate normals by the last valid one, and at which edges this fails (Eqs 19, 20);
* that a proxy needs none of this, because it remembers the side from which the tool came.

    python examples/04_angle_of_a_face.py --degrees 40 --depth 6 --noise 5
"""

import numpy as np
import tyro

import palpate
from palpate.scene.contact.lessons.face_angle import Slide, candidates, contact_normal_error, eq20, face_angle

RADIUS, STEP = 15e-3, 0.08e-3  # the paper's sphere [m]; a tick at 20 mm/s and 250 Hz [m]


def angle_by_motion(slide: Slide, noise: float, baseline: float, seed: int = 0) -> np.ndarray:
    """Angles from Eq 18, for every tick of the slide that is at least a baseline from the last one used [deg]."""
    first, last = slide.travel(2000)[[0, -1]]
    points = slide.contact(np.arange(first, last, STEP))
    points = points + noise * np.random.default_rng(seed).normal(size=points.shape)
    found, before = [], points[0]
    for now in points[1:]:
        try:
            found.append(face_angle(before, now, baseline))
        except ValueError:  # the baseline is not reached yet
            continue
        before = now
    return np.degrees(found)


def proxy_error(degrees: float, depth: float) -> float:
    """Error of the default method where both faces touch the tool: angle of its force to the exact force [deg]."""
    x = np.arange(-0.04, 0.0401, 0.001)  # two half-spaces as a grid: a groove of two faces
    nodes = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)
    half = np.radians(degrees) / 2
    normal = np.array([-np.sin(2 * half), 0.0, np.cos(2 * half)])
    grid = palpate.surfaces.DistanceGrid(np.minimum(nodes[..., 2], nodes @ normal), np.full(3, x[0]), 0.001)
    middle = np.array([-np.sin(half), 0.0, np.cos(half)])  # equal depth in both faces
    tool = (RADIUS - depth) / np.cos(half) * middle
    tips = np.linspace(tool + 0.03 * middle, tool, 400)
    force = palpate.contact.render(grid, tips, radius=RADIUS, stiffness=500.0).force[-1]
    return float(np.degrees(np.arccos(np.clip(force @ middle / np.linalg.norm(force), -1, 1))))


def main(degrees: float = 40.0, depth: float = 6.0, noise: float = 5.0) -> None:
    """Print the results for one edge.

    Args:
        degrees: angle of the next face; negative for a convex edge.
        depth: depth of the circle in the first face [mm].
        noise: noise of each coordinate of a contact point [um].
    """
    slide = Slide(np.radians(degrees), RADIUS, 1e-3 * depth)
    print(f"a circle of {1e3 * RADIUS:g} mm, {depth:g} mm deep, toward a face at {degrees:g} deg")
    print(f"normal from contact point to centre: {contact_normal_error(RADIUS, 1e-3 * depth):5.1f} deg off (Fig 9B)")

    print("Eq 18 from tick to tick | noise um | baseline um | median deg | worst deg off")
    for sigma, baseline in ((0.0, 0.0), (1e-6 * noise, 0.0), (1e-6 * noise, 1e-3)):
        found = angle_by_motion(slide, sigma, baseline)
        found = degrees + (found - degrees + 90.0) % 180.0 - 90.0  # a line has no sign: add 180 deg
        row = f"{1e6 * sigma:8g} | {1e6 * baseline:11g} | {np.median(found):10.3f}"
        print(f"{'':23s} | {row} | {np.abs(found - degrees).max():13.2g}")

    picked, fails = eq20(slide)
    for n in candidates(slide.phi_f):
        mark = "picked by Eq 20" if n @ picked > 0 else ""
        print(f"Eq 19 candidate ({n[0]:+.3f}, {n[1]:+.3f}) {mark}")
    print(f"Eq 20 is {'wrong here: ' + fails if fails else 'right here'}")
    if 0.0 < degrees < 90.0:
        print(f"the proxy, in the edge on both faces: {proxy_error(degrees, 1e-3 * depth):.2g} deg off")


if __name__ == "__main__":
    tyro.cli(main)
