"""Method `paper-alg1`: the correct results and the known failures of the paper's Algorithm 1."""

import numpy as np
import pytest

import palpate
from palpate.scene.contact.algorithm1 import trace_algorithm1

K, R = 500.0, 0.002  # [N/m], [m]


def box(side: float = 0.04) -> tuple[np.ndarray, np.ndarray]:
    """A cube of 12 triangles whose top lies at z = 0."""
    h = side / 2
    v = np.array([[x, y, z] for z in (-side, 0.0) for y in (-h, h) for x in (-h, h)])
    f = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]]
    f += [[2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]
    return v, np.array(f)


def press(z: float, x: float = 0.01, y: float = -0.003) -> np.ndarray:
    """Tool positions that come down on the top of the box, clear of the face's diagonal, and rest at z."""
    down = np.linspace(0.004, z, 200)
    return np.column_stack([np.full(300, x), np.full(300, y), np.r_[down, np.full(100, z)]])


def render(tips: np.ndarray, method: str = "paper-alg1", rate: float = 1000.0, **options: float):
    return palpate.contact.render(box(), tips, radius=R, stiffness=K, method=method, rate=rate, **options)


@pytest.mark.parametrize("z", [0.0015, 0.001, 0.0002])
def test_shallow_press_on_a_plane_is_exact(z):
    out = render(press(z))
    assert out.force[-1] == pytest.approx([0, 0, K * (R - z)], abs=1e-9)
    assert out.normal[-1] == pytest.approx([0, 0, 1], abs=1e-12)
    assert out.proxy[-1] == pytest.approx([0.01, -0.003, R], abs=1e-12)


def test_release_is_exactly_zero():
    path = press(0.001)
    out = render(np.vstack([path, path[::-1]]))
    assert np.abs(out.force[250:300]).max() > 0.4
    assert (out.force[-100:] == 0.0).all()
    assert (out.normal[-100:] == 0.0).all()
    above = np.vstack([path, path[::-1]])[:, 2] >= R
    assert (out.force[above] == 0.0).all(), "the haptic cycle releases at once, not after a collision period"


def test_contact_force_starts_one_collision_period_late():
    """Contacts found at k / 250 s are used from the next instant on, 4 to 8 ticks after the tool has entered."""
    for step_at in range(100, 108):
        z = np.where(np.arange(200) < step_at, 0.004, 0.001)
        out = render(np.column_stack([np.full(200, 0.01), np.full(200, -0.003), z]))
        first = int(np.argmax(out.depth > 0))
        assert first % 4 == 0
        assert 4 <= first - step_at < 8


def test_same_path_gives_the_same_forces():
    rng = np.random.default_rng(7)
    path = press(0.001) + np.cumsum(rng.normal(scale=2e-5, size=(300, 3)), axis=0)
    a, b = render(path), render(path)
    for name in ("force", "normal", "depth", "proxy"):
        assert np.array_equal(getattr(a, name), getattr(b, name))


def test_damping_acts_along_the_normal_and_never_pulls():
    path = press(0.0005)
    out, spring = render(path, damping=20.0), render(path)
    touched = spring.depth > 0
    assert (out.force[:, 2] >= 0).all()
    assert np.abs(out.force[touched, :2]).max() < 1e-9
    going_in = touched & (np.arange(300) < 200)
    assert (out.force[going_in, 2] > spring.force[going_in, 2]).all()


# ---- failures described in section 3.1 of the paper, and further ones: facts about the method, not requirements


def test_fact_normals_point_inwards_once_the_centre_is_below_the_surface():
    """At 1 mm below, 500 N/m x 3 mm outwards is correct; Algorithm 1 on Coal gives 500 N/m x 1 mm *inwards*."""
    paper, proxy = render(press(-0.001)), render(press(-0.001), method="proxy")
    assert proxy.force[-1] == pytest.approx([0, 0, K * 0.003], rel=1e-6)
    assert paper.force[-1] == pytest.approx([0, 0, -K * 0.001], rel=1e-6)
    depth_along_truth = paper.force[-1, 2] / K
    assert 0.003 - depth_along_truth == pytest.approx(2 * R)


def test_fact_sphere_completely_inside_gets_no_force():
    paper, proxy = render(press(-0.003)), render(press(-0.003), method="proxy")
    assert (paper.force[-1] == 0.0).all()
    assert proxy.force[-1] == pytest.approx([0, 0, K * 0.005], rel=1e-6)


def test_fact_neighbouring_triangle_of_the_same_plane_tilts_the_average():
    """Near the diagonal of a flat face the normal of the farther point is tilted; the proxy is not affected."""
    tip = (0.003, 0.001, 0.001)
    trace = trace_algorithm1(box(), tip, radius=R, stiffness=K)
    assert len(trace.points) == 2
    lean = np.array([0.003 - 0.002, 0.001 - 0.002, 0.001]) / np.linalg.norm([0.001, -0.001, 0.001])
    n = (np.array([0, 0, 1.0]) + lean) / np.linalg.norm(np.array([0, 0, 1.0]) + lean)
    assert trace.normal == pytest.approx(n, abs=1e-9)
    assert np.degrees(np.arccos(trace.normal[2])) == pytest.approx(27.4, abs=0.1)
    proxy = palpate.contact.render(box(), [[*tip[:2], 0.004], tip], radius=R, stiffness=K)
    assert proxy.normal[-1] == pytest.approx([0, 0, 1], abs=1e-9)


# ---- the nine lines


def test_nine_lines_of_the_algorithm_for_one_contact():
    tip, v = np.array([0.01, -0.003, 0.0012]), np.array([0.01, 0.02, -0.03])
    t = trace_algorithm1(box(), tip, radius=R, stiffness=[500, 600, 700], damping=[1, 2, 3], velocity=v)
    assert t.collision
    assert t.points == pytest.approx(np.array([[0.01, -0.003, 0.0]]), abs=1e-12)  # 2: foot of the centre
    assert t.normals == pytest.approx(np.array([[0.0, 0.0, 1.0]]), abs=1e-12)  # 3
    assert t.normal == pytest.approx([0, 0, 1], abs=1e-12)  # 4
    assert t.delta_x_total == pytest.approx([0, 0, R - 0.0012], abs=1e-12)  # 5
    assert (t.v_total == v).all()  # 6
    assert t.delta_x == pytest.approx([0, 0, R - 0.0012], abs=1e-12)  # 7
    assert t.v == pytest.approx([0, 0, -0.03], abs=1e-12)  # 8
    assert t.force == pytest.approx([0, 0, 700 * (R - 0.0012) + 3 * 0.03], abs=1e-9)  # 9
    lines = str(t).splitlines()
    assert [line[0] for line in lines] == list("123456789")
    assert "0.6500" in lines[-1]


def test_no_collision_ends_the_loop():
    t = trace_algorithm1(box(), (0, 0, 0.0021), radius=R, stiffness=K)
    assert not t.collision
    assert (t.force == 0.0).all()
    assert str(t) == "1 no collision: F = 0"


def test_vanishing_sum_keeps_the_last_normal():
    """With the centre exactly in the plane, Coal's only normal is zero, and so is the sum."""
    tip = (0.01, -0.003, 0.0)
    assert np.linalg.norm(trace_algorithm1(box(), tip, radius=R, stiffness=K).normals.sum(axis=0)) < 1e-12
    t = trace_algorithm1(box(), tip, radius=R, stiffness=K, last_normal=(0, 0, 1))
    assert (t.normal == [0, 0, 1]).all()
    assert np.isfinite(t.force).all()


def test_at_most_fifteen_points():
    x = np.linspace(-0.01, 0.01, 41)
    v = np.array([[a, b, 0.0] for a in x for b in x])
    i = (np.arange(40)[:, None] * 41 + np.arange(40)).ravel()
    f = np.vstack([np.column_stack([i, i + 41, i + 42]), np.column_stack([i, i + 42, i + 1])])
    with pytest.warns(palpate.base.errors.PalpateWarning, match="open"):
        t = trace_algorithm1((v, f), (0, 0, 0.001), radius=R, stiffness=K)
    assert len(t.points) == 15


def test_invalid_arguments_are_reported():
    with pytest.raises(ValueError, match=r"radius must be a positive number in m, got -1"):
        trace_algorithm1(box(), (0, 0, 0), radius=-1, stiffness=K)
    with pytest.raises(ValueError, match=r"tip must be three finite numbers, got \[0.0, nan, 0.0\]"):
        trace_algorithm1(box(), (0, float("nan"), 0), radius=R, stiffness=K)
