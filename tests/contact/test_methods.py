"""The methods other than the default: exact and wrong in the cases that the paper states."""

import numpy as np
import pytest

import palpate
from palpate import _collision, _core
from palpate.scene import ContactSection
from palpate.scene.contact.rendering import snapshot_of
from palpate.scene.contact_method import COLLISIONS, METHODS
from palpate.world.shapes.analytic import SHAPES, Box, Groove, Sphere

K, R = 500.0, 0.002  # [N/m], [m]
BOX = Box().mesh(10_000)
TOP = 0.02  # height of the box's top face [m]


def render(surface, tips, method: str, rate: float = 1000.0):
    return palpate.contact.render(surface, tips, radius=R, stiffness=K, method=method, rate=rate)


def angle_deg(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1)))


def line(a, b, n: int) -> np.ndarray:
    return np.linspace(a, b, n)


def press(depth: float, n: int = 300) -> np.ndarray:
    """A path (n, 3) straight down on the box, a rest, and straight up; the last rows are in free space."""
    z = TOP + np.r_[np.linspace(0.004, R - depth, n), np.full(n, R - depth), np.linspace(R - depth, 0.004, n)]
    return np.column_stack([np.full(3 * n, 0.0031), np.full(3 * n, -0.0042), z])


def test_method_names_are_the_same_everywhere():
    assert ContactSection.model_json_schema()["properties"]["method"]["anyOf"][0]["enum"] == list(METHODS)
    assert METHODS[0] == ContactSection().method == "proxy"
    assert set(METHODS) <= set(_core.contact_methods()), "the core, and the part that is imported above"


@pytest.mark.parametrize("method", METHODS)
def test_a_shallow_press_on_a_plane_is_exact(method):
    """Only one facet touches the sphere, so the average of Algorithm 1 has a single normal."""
    out = render(Box().mesh(12), press(0.001), method)
    assert out.force[450] == pytest.approx([0, 0, K * 0.001], abs=1e-9)
    assert out.normal[450] == pytest.approx([0, 0, 1], abs=1e-9)
    assert out.depth[450] == pytest.approx(0.001, abs=1e-12)
    assert out.proxy[450] == pytest.approx([0.0031, -0.0042, TOP + R], abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_release_is_exactly_zero(method):
    tips = press(0.001)
    out = render(BOX, tips, method)
    assert np.abs(out.force).max() > 0.3
    assert (out.force[tips[:, 2] >= TOP + R] == 0.0).all()


@pytest.mark.parametrize("method", METHODS)
def test_force_moves_with_the_object(method):
    """If object and path are rotated and moved together, the force rotates with them."""
    X = np.eye(4)
    X[:3, :3] = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    X[:3, :3] *= np.linalg.det(X[:3, :3])
    X[:3, 3] = (0.3, -0.2, 0.1)
    tips = press(0.0012)[:500] + np.linspace(0, 0.005, 500)[:, None] * [1.0, 0.4, 0.0]
    mesh, material = _core.Mesh(*SHAPES["sphere"].mesh(10_000)), _core.Material(K=np.full(3, K))
    tips[:, 2] += 0.03 - TOP
    options = _core.ContactOptions()

    def force(pose, path):
        snapshot = _core.Snapshot([_core.Object("object", mesh, pose, material)])
        return _core.contact_render(snapshot, np.ascontiguousarray(path), method, options, 1000.0)[0]

    still, moved = force(np.eye(4), tips), force(X, tips @ X[:3, :3].T + X[:3, 3])
    assert np.linalg.norm(still, axis=1).max() > 0.1
    assert moved == pytest.approx(still @ X[:3, :3].T, abs=1e-6)


# ---- surfaces other than meshes


@pytest.mark.parametrize("method", COLLISIONS)
def test_triangle_methods_reject_other_surfaces(method):
    tips = [[0, 0, 0.04], [0, 0, 0.031]]
    with pytest.raises(ValueError, match=r"object 'surface' has no triangles.* use method proxy or penalty"):
        render(palpate.surfaces.Sphere(0.03), tips, method)


@pytest.mark.parametrize("method", ["proxy", "penalty"])
def test_other_methods_render_all_surfaces(method):
    z = np.linspace(0.04, 0.031, 300)
    out = render(palpate.surfaces.Sphere(0.03), np.column_stack([0 * z, 0 * z, z]), method)
    assert out.force[-1] == pytest.approx([0, 0, K * 0.001], abs=1e-9)


# ---- penalty


def test_penalty_is_exact_on_a_sphere_up_to_the_facets():
    """On a finely tessellated sphere the direction is that of a facet, wrong by at most half a facet."""
    shape = Sphere()
    mesh = shape.mesh(100_000)
    tips = shape.curve(np.linspace(0, 1, 2000), 0.0005)
    out = render(mesh, tips, "penalty")
    phi, n = shape.distance(tips)
    edge = 0.030 * np.arccos(1 / np.sqrt(5)) / np.sqrt(100_000 / 20)  # approximate edge of a facet [m]
    assert angle_deg(out.normal, n).max() < np.degrees(edge / 0.030)
    assert out.depth == pytest.approx(R - phi, abs=edge**2 / (2 * 0.030))  # sagitta of a facet


def test_penalty_pops_through_a_plate_but_the_proxy_does_not():
    """A plate of 1 mm, pressed 3 mm deep: beyond its middle the nearest side is the opposite one."""
    plate = SHAPES["plate"].mesh(2000)
    z = np.r_[np.linspace(0.004, -0.003, 1500)]
    tips = np.column_stack([np.full(1500, 0.0013), np.full(1500, 0.0007), z])
    penalty, proxy = (render(plate, tips, m) for m in ("penalty", "proxy"))
    assert (proxy.force[tips[:, 2] < R, 2] > 0).all()
    past = tips[:, 2] < -1e-5
    assert (penalty.force[past, 2] <= 0).all()
    assert penalty.force[past, 2].min() < -0.9  # the force points out of the opposite side
    assert (penalty.force[(tips[:, 2] > 1e-5) & (tips[:, 2] < R), 2] > 0).all()


# ---- approach-velocity


@pytest.mark.parametrize("degrees", [0.0, 15.0, 45.0, 75.0])
def test_approach_velocity_errs_by_the_angle_of_approach(degrees):
    """Section 3.1 of the paper: correct only at 0 degrees."""
    a = np.radians(degrees)
    end = np.array([0.0011, 0.0007, TOP + 0.001])
    start = end + np.array([-0.004 * np.tan(a), 0.0, 0.004])
    tips = np.vstack([line(start, end, 400), np.tile(end, (20, 1))])  # a rest longer than a collision period
    out = render(Box().mesh(12), tips, "approach-velocity")
    assert angle_deg(out.force[-1], np.array([0, 0, 1.0])) == pytest.approx(degrees, abs=1e-6)
    assert np.linalg.norm(out.force[-1]) == pytest.approx(K * 0.001 * np.cos(a), rel=1e-6)  # line 7 projects


def test_approach_velocity_gives_no_force_if_the_tool_starts_in_contact():
    out = render(BOX, np.tile([0.0, 0.0, TOP + 0.001], (50, 1)), "approach-velocity")
    assert (out.force == 0).all()


# ---- face-normal


def test_face_normals_are_right_on_a_plane_while_the_sphere_touches_it():
    for z in (0.0015, 0.0005, -0.0005, -0.0015):
        out = render(BOX, press(R - z), "face-normal")
        assert out.force[450] == pytest.approx([0, 0, K * (R - z)], abs=1e-9)
    assert (render(BOX, press(R + 0.003), "face-normal").force[450] == 0).all(), "a sphere inside touches no facet"


def test_face_normals_average_over_an_edge():
    """The sphere on the top face, 0.5 mm from the edge, also touches the side; the correct force is straight up."""
    tips = line((0.0195, 0.001, TOP + 0.004), (0.0195, 0.001, TOP + 0.0008), 400)
    out = render(Box().mesh(12), tips, "face-normal")
    assert out.normal[-1] == pytest.approx(np.array([1, 0, 1]) / np.sqrt(2), abs=1e-9)


# ---- paper-plane


def test_plane_through_three_points():
    n = _collision.grow_plane(np.array([[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0]]), np.array([0.1, 0, 1.0]), 1e-4)
    assert n == pytest.approx([0, 0, 1], abs=1e-12)
    n = _collision.grow_plane(np.array([[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0]]), np.array([0.1, 0, -1.0]), 1e-4)
    assert n == pytest.approx([0, 0, -1], abs=1e-12)


@pytest.mark.parametrize(
    ("points", "n_last"),
    [
        ([[0, 0, 0], [1, 0, 0]], [0, 0, 1]),  # two points
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [0, 0, 1]),  # collinear
        ([[0, 0, 0], [1, 0, 0], [2, 0.1, 0]], [0, 0, 1]),  # nearly collinear
        ([[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0]], [0, 0, 1]),  # closer than the baseline
        ([[0, 0, 0], [1, 0, 0], [0, 0, -1]], [0, 0, 1]),  # x_n in the plane: Eq 20 cannot distinguish the sides
    ],
)
def test_degenerate_point_sets_are_rejected(points, n_last):
    assert (_collision.grow_plane(np.array(points) * 1e-3, np.array(n_last, float), 1e-4) == 0).all()


def test_normal_of_a_least_squares_plane_is_the_singular_vector():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(15, 3)) * [1e-3, 7e-4, 1e-5] @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    n = np.linalg.svd(points - points.mean(axis=0))[2][-1]
    assert np.abs(_collision.grow_plane(points, n, 1e-4) @ n) == pytest.approx(1, abs=1e-12)


def test_paper_plane_is_right_below_a_plane_where_algorithm_1_flips():
    """The tool moves on the box's top with its centre 1 mm below it."""
    t = np.linspace(0, 1, 2000)
    wander = np.column_stack([0.006 * np.cos(9 * t), 0.005 * np.sin(7 * t), np.full(2000, TOP - 0.001)])
    down = line(wander[0] + [0, 0, 0.005], wander[0], 800)
    tips = np.vstack([down, wander])
    plane, paper = render(BOX, tips, "paper-plane"), render(BOX, tips, "paper-alg1")
    assert plane.force[-1000:] == pytest.approx(np.tile([0, 0, K * 0.003], (1000, 1)), abs=1e-6)
    assert (paper.force[-1000:, 2] <= 0).all()


@pytest.mark.parametrize("shape", ["sphere", "torus"])
def test_paper_plane_on_convex_and_smooth_surfaces(shape):
    """The tool slides 1 mm above; the points lie anywhere in the patch cut by the sphere, which limits the tilt."""
    path = SHAPES[shape].curve(np.linspace(0, 0.5, 3000), 0.001)
    n = SHAPES[shape].distance(path[:1])[1][0]
    tips = np.vstack([line(path[0] + 0.004 * n, path[0], 300), path])
    out = render(SHAPES[shape].mesh(10_000), tips, "paper-plane")
    error = angle_deg(out.force[400:], SHAPES[shape].distance(tips[400:])[1])
    curvature = {"sphere": 1 / 0.030, "torus": 1 / 0.015}[shape]  # the larger curvature [1/m]
    assert error.max() < np.degrees(np.sqrt(R**2 - 0.001**2) * curvature)


@pytest.mark.filterwarnings("ignore::palpate.base.errors.PalpateWarning")
def test_fact_paper_plane_pushes_into_a_wall_of_a_sharp_concave_edge():
    """Eq 20 assumes "locally convex". In a V of 60 degrees the walls' normals are 120 degrees apart."""
    wall = np.radians(60)
    v, f = Groove().mesh(20_000)
    v = v * [1, 1, np.tan(wall)]
    down = np.array([1.0, 0.0, np.tan(wall)]) / np.hypot(1, np.tan(wall))  # upwards along the wall x > 0
    n1, n2 = np.array([-np.sin(wall), 0, np.cos(wall)]), np.array([np.sin(wall), 0, np.cos(wall)])
    t = np.linspace(0, 1, 4000)
    along, y = 0.03 - 0.029 * t, 0.002 * np.sin(60 * t)  # to and fro, so that the points are not collinear
    tips = np.outer(along, down) + np.outer(y, [0, 1, 0]) + 0.0005 * n1
    tips = np.vstack([line(tips[0] + 0.004 * n1, tips[0], 300), tips])
    paper, proxy = render((v, f), tips, "paper-plane"), render((v, f), tips, "proxy")
    on_wall = slice(1000, 2500)
    assert angle_deg(paper.force[on_wall], n1).max() < 1
    corner = np.flatnonzero((tips @ n2 < R) & (np.arange(len(tips)) > 400))  # in contact with both walls
    truth = np.column_stack([np.zeros(len(corner)), tips[corner, 1], np.full(len(corner), R / np.cos(wall))])
    truth -= tips[corner]
    assert proxy.force[corner] == pytest.approx(K * truth, abs=0.002)
    assert angle_deg(paper.force[corner], truth).max() > 90
    assert (paper.force[corner] @ n1).min() < -0.1, "the force pushes into the first wall"


@pytest.mark.parametrize("method", METHODS[1:])
def test_invalid_tool_position_gives_no_force_and_no_later_error(method):
    tips = press(0.001)[:600]
    expected = render(Box().mesh(12), tips, method)
    options = _core.ContactOptions()
    snapshot = snapshot_of(Box().mesh(12), stiffness=K)
    tips[400] = np.nan
    force = _core.contact_render(snapshot, tips, method, options, 1000.0)[0]
    assert np.isfinite(force).all()
    assert force[450] == pytest.approx(expected.force[450], abs=1e-9)
