"""Each role and law against its closed form, finite differences, a change of frame, and its work."""

import numpy as np
import pytest
from fixtures import filled, fixture, placed, plane, pose, sphere
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

LINE = _guidance.LineGeometry(np.zeros(3), np.array([0.0, 0.0, 0.1]), True)
STILL = np.zeros(6)


def evaluate(f, p=(0.0, 0.0, 0.0), R=None, V=STILL, **more):
    return f.evaluate(pose(p, R), V_WT=V, **more)


def test_names_of_roles_and_laws():
    assert _guidance.guidance_roles() == ["guide", "forbid", "keep-in", "orient", "limit", "rcm"]
    assert _guidance.guidance_laws() == ["spring", "potential", "admittance", "optimise"]


# ---- roles


def test_guide_constrains_to_the_line_and_leaves_the_motion_along_it_free():
    result = evaluate(fixture(placed(LINE), "guide", role_={"margin": 0.001}), (0.03, 0.04, 0.7))
    assert result["gap"] == pytest.approx(0.001 - 0.05)
    np.testing.assert_allclose(result["along"], [-0.6, -0.8, 0, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(result["free"], np.diag([0.0, 0.0, 1.0]), atol=1e-12)
    assert result["attracts"]


def test_guide_to_a_surface_attracts_from_both_sides():
    f = fixture(sphere(0.03), "guide")
    for r, sign in ((0.05, -1.0), (0.02, 1.0)):
        result = evaluate(f, (r, 0.0, 0.0))
        assert result["gap"] == pytest.approx(-abs(r - 0.03))
        np.testing.assert_allclose(result["along"][:3], [sign, 0, 0], atol=1e-12)


@pytest.mark.parametrize(("role", "sign"), [("forbid", 1.0), ("keep-in", -1.0)])
def test_forbid_and_keep_in_are_opposite(role, sign):
    result = evaluate(fixture(sphere(0.03), role, role_={"margin": 0.002}), (0.0, 0.04, 0.0))
    assert result["gap"] == pytest.approx(sign * 0.01 - 0.002)
    np.testing.assert_allclose(result["along"][:3], [0, sign, 0], atol=1e-12)
    assert not result["attracts"]


def test_forbidden_line_needs_a_margin_and_acts_as_a_tube():
    result = evaluate(fixture(placed(LINE), "forbid", role_={"margin": 0.003}), (0.002, 0.0, 0.0))
    assert result["gap"] == pytest.approx(-0.001)
    with pytest.raises(ValueError, match="role forbid needs a geometry with an inside"):
        _guidance.Fixtures([fixture(placed(LINE), "forbid")])


@pytest.mark.parametrize("target", ["axis", "normal", "frame"])
@pytest.mark.parametrize("angle", [1e-4, 0.3, 3.0])
def test_orient_rotates_by_the_shortest_path(target, angle):
    """The gradient of the gap is a unit rotation towards the target, for each target."""
    base = Rotation.from_rotvec([np.pi, 0, 0]) if target == "normal" else Rotation.identity()  # z opposite to z
    axis = np.array([0.6, 0.8, 0.0])
    R = (Rotation.from_rotvec(angle * axis) * base).as_matrix()
    result = evaluate(fixture(plane(), "orient", role_={"target": target, "angle": 0.1}), (0, 0, 0.01), R)
    assert result["gap"] == pytest.approx(0.1 - angle, abs=1e-7)
    np.testing.assert_allclose(result["along"][3:], -axis, atol=1e-6)
    assert result["turns"]


def test_rcm_needs_a_point():
    with pytest.raises(ValueError, match="role rcm needs a point, the place that the shaft passes through"):
        _guidance.Fixtures([fixture(sphere(), "rcm")])


def test_rcm_measures_the_distance_of_the_shaft_to_the_point():
    """A shaft along y, with its tip 0.1 m beyond the point and 5 mm next to it."""
    R = Rotation.from_rotvec([-np.pi / 2, 0, 0]).as_matrix()  # z of T along y of W
    result = evaluate(fixture(placed(_guidance.PointGeometry()), "rcm"), (0.005, 0.1, 0.0), R)
    assert result["gap"] == pytest.approx(-0.005)
    np.testing.assert_allclose(result["along"][:3], [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(result["along"][3:], np.cross([0, -0.1, 0], [-1, 0, 0]), atol=1e-12)


@pytest.mark.parametrize("role", ["guide", "forbid", "keep-in", "rcm", "orient"])
def test_gap_gradient_matches_finite_differences(role):
    """d gap = along.f . dp + along.t . rotation, for random tool poses."""
    rng = np.random.default_rng(2)
    geometry = placed(_guidance.PointGeometry(), pose((0.01, 0.02, -0.01))) if role == "rcm" else sphere(0.03)
    f = fixture(geometry, role)
    for _ in range(50):
        R = Rotation.random(random_state=rng)
        p = rng.normal(size=3) * 0.03
        V, h = rng.normal(size=6), 1e-6
        gaps = [
            evaluate(f, p + s * h * V[:3], (Rotation.from_rotvec(s * h * V[3:]) * R).as_matrix())["gap"]
            for s in (1, -1)
        ]
        slope = evaluate(f, p, R.as_matrix())["along"] @ V
        assert (gaps[0] - gaps[1]) / (2 * h) == pytest.approx(slope, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("role", ["guide", "forbid", "keep-in"])
def test_drift_is_the_time_derivative_of_the_gap(role):
    motion = _core.Motion(waves=[_core.Wave(shift=np.array([0.01, 0.0, 0.02]), turn=np.zeros(3), period=0.7)])
    f = fixture(sphere(0.03, motion=motion), role)
    p, h = np.array([0.02, 0.03, 0.04]), 1e-6
    for t in (0.1, 0.2, 0.55):
        numeric = (f.evaluate(pose(p), t + h)["gap"] - f.evaluate(pose(p), t - h)["gap"]) / (2 * h)
        assert f.evaluate(pose(p), t)["drift"] == pytest.approx(numeric, abs=1e-6)


def test_force_limit_gives_a_displacement_away_from_the_contact():
    f = fixture(sphere(0.1), "limit", role_={"force": 2.0})
    result = evaluate(f, F_T_W=np.array([0.0, 0.0, 3.0]), stiffness=500.0)
    assert result["gap"] == pytest.approx(-1.0 / 500.0)
    np.testing.assert_allclose(result["along"][:3], [0, 0, 1])
    assert evaluate(f, (0.2, 0.0, 0.0), F_T_W=np.array([0.0, 0.0, 3.0]))["gap"] == np.inf, "outside: inactive"


def test_limits_of_speed_and_of_position():
    speed = fixture(sphere(0.1), "limit", role_={"speed": 0.02})
    assert evaluate(speed)["speed"] == 0.02
    assert evaluate(speed, (0.2, 0, 0))["speed"] == np.inf
    position = evaluate(fixture(sphere(0.1), "limit"), (0.12, 0.0, 0.0))
    assert position["gap"] == pytest.approx(-0.02)


# ---- laws


def profile(law, e, role="guide", **options):
    """Force and energy of a law at deviations e [m] from a point, or for repelling roles from a sphere's surface."""
    geometry = placed(_guidance.PointGeometry()) if role == "guide" else plane()
    f = fixture(geometry, role, law, law_=options)
    found = [evaluate(f, (0.0, 0.0, x if role == "guide" else -x)) for x in np.atleast_1d(e)]
    sign = -1.0 if role == "guide" else 1.0
    return np.array([sign * one["F"][2] for one in found]), np.array([one["U"] for one in found])


def test_spring_is_linear():
    e = np.array([0.0, 0.001, 0.004])
    F, U = profile("spring", e, K=300.0)
    np.testing.assert_allclose(F, 300.0 * e, atol=1e-12)
    np.testing.assert_allclose(U, 150.0 * e**2, atol=1e-15)


def test_optimise_saturates():
    F, _ = profile("optimise", [0.002, 0.1], K=300.0, force=2.0)
    np.testing.assert_allclose(F, [0.6, 2.0], atol=1e-12)


def test_potential_rises_holds_and_fades():
    F, _ = profile("potential", [0.002, 0.007, 0.009, 0.02], K=300.0, force=1.5, range=0.01)
    np.testing.assert_allclose(F, [0.6, 1.5, 0.75, 0.0], atol=1e-9)


def test_repelling_potential_acts_before_the_border():
    F, _ = profile("potential", [-0.012, -0.006, 0.0, 0.05], role="forbid", K=300.0, force=2.0, range=0.01)
    np.testing.assert_allclose(F, [0.0, 1.2, 2.0, 2.0], atol=1e-9)


@pytest.mark.parametrize("law", ["spring", "potential", "optimise"])
@pytest.mark.parametrize("role", ["guide", "forbid"])
def test_force_of_a_law_is_the_gradient_of_its_energy(law, role):
    e, h = np.linspace(-0.02, 0.03, 401) + 1.3e-5, 1e-7
    if role == "guide":
        e = np.abs(e)
    F, _ = profile(law, e, role, K=250.0, force=1.7, range=0.012)
    U = [profile(law, e + s * h, role, K=250.0, force=1.7, range=0.012)[1] for s in (1, -1)]
    smooth = np.abs(np.gradient(np.gradient(F))) < 1e-6  # away from the kinks
    np.testing.assert_allclose(F[smooth], ((U[0] - U[1]) / (2 * h))[smooth], atol=2e-6)
    assert smooth.sum() > 350


def test_damping_dissipates_and_never_reverses_the_force():
    f = fixture(plane(), "forbid", law_={"K": 400.0, "B": 5.0})
    for z in (-1e-6, -1e-4, -0.002):
        for v in (-0.5, -0.01, 0.01, 0.5):
            F = evaluate(f, (0, 0, z), V=np.array([0, 0, v, 0, 0, 0]))["F"][2]
            assert F >= 0.0, "the force pushes and never pulls"
            assert (F - 400.0 * -z) * v <= 1e-12, "the force in addition to the spring dissipates"
    assert evaluate(f, (0, 0, -1e-9), V=np.array([0, 0, -0.5, 0, 0, 0]))["F"][2] < 1e-4, "no step at the border"


def test_admittance_moves_ratio_times_as_fast_across():
    f = fixture(placed(LINE), "guide", "admittance", law_={"B": 3.0, "ratio": 0.2})
    B = evaluate(f, (1e-9, 0.0, 0.0), V=np.array([0.01, 0.0, 0.02, 0, 0, 0]))["B"]
    v = np.linalg.solve(B, [1.0, 1.0, 1.0])  # speed under the same force in each direction
    np.testing.assert_allclose(v[[0, 1]] / v[2], 0.2, atol=1e-4)
    assert v[2] == pytest.approx(1 / 3.0)


def test_admittance_damps_the_motion_back_less():
    f = fixture(placed(LINE), "guide", "admittance", law_={"B": 3.0, "ratio": 0.2})
    away, back = (evaluate(f, (0.01, 0.0, 0.0), V=np.array([v, 0, 0, 0, 0, 0]))["F"][0] for v in (0.01, -0.01))
    assert away == pytest.approx(-0.01 * 15.0)
    assert back == pytest.approx(0.01 * 3.0)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["guide", "forbid", "keep-in", "orient", "rcm"]))
def test_admittance_only_dissipates(seed, role):
    """At random poses and velocities the power is never positive."""
    rng = np.random.default_rng(seed)
    geometry = placed(_guidance.PointGeometry()) if role == "rcm" else sphere(0.03)
    f = fixture(geometry, role, "admittance", law_={"B": 3.0, "ratio": rng.uniform(0.01, 1.0)})
    V = rng.normal(size=6)
    found = evaluate(f, 0.05 * rng.normal(size=3), Rotation.random(random_state=rng).as_matrix(), V)
    assert found["F"] @ V <= 1e-12
    assert np.linalg.eigvalsh(found["B"] + found["B"].T).min() > -1e-9


@pytest.mark.parametrize("law", ["spring", "potential", "optimise"])
@pytest.mark.parametrize("role", ["guide", "forbid", "keep-in", "rcm", "orient"])
def test_resting_fixture_adds_no_energy_on_a_closed_path(role, law):
    """For springs and potentials the work on any closed path is minus the dissipated energy."""
    options = {"K": 300.0, "B": 0.0, "B_turn": 0.0, "range": 0.02}
    geometry = placed(_guidance.PointGeometry()) if role == "rcm" else sphere(0.03)
    f = fixture(geometry, role, law, law_=options)
    s = np.linspace(0.0, 2 * np.pi, 4001)
    p = 0.03 * np.stack([np.cos(s), np.sin(2 * s), 0.3 + np.sin(s)], axis=1)
    turns = Rotation.from_rotvec(0.4 * np.stack([np.sin(s), np.cos(s), np.sin(3 * s)], axis=1))
    F = np.array([evaluate(f, x, R.as_matrix())["F"] for x, R in zip(p, turns, strict=True)])
    steps = np.hstack([np.diff(p, axis=0), (turns[1:] * turns[:-1].inv()).as_rotvec()])
    work = (0.5 * (F[1:] + F[:-1]) * steps).sum()
    most = np.abs(F[1:] * steps).sum()
    assert abs(work) < 1e-3 * most + 1e-9


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(["guide", "forbid", "keep-in", "orient", "rcm"]),
    st.sampled_from(["spring", "potential", "admittance", "optimise"]),
)
def test_wrench_is_independent_of_the_frame(seed, role, law):
    """If geometry, tool and motion are moved together, the result moves with them."""
    rng = np.random.default_rng(seed)
    line = _guidance.LineGeometry(np.zeros(3), np.array([0.01, 0.02, 0.1]))
    geometry, X = _guidance.PointGeometry() if role == "rcm" else line, np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
    p, R, V = 0.02 * rng.normal(size=3), Rotation.random(random_state=rng).as_matrix(), rng.normal(size=6)
    options = {"role_": {"margin": 0.001} if role != "keep-in" else {}, "law_": {"range": 0.05}}
    made = [sphere(0.01, at) if role == "keep-in" else placed(geometry, at) for at in (None, X)]
    one = evaluate(fixture(made[0], role, law, **options), p, R, V)
    turned = np.concatenate([X[:3, :3] @ V[:3], X[:3, :3] @ V[3:]])
    other = fixture(made[1], role, law, **options).evaluate(X @ pose(p, R), V_WT=turned)
    back = np.concatenate([X[:3, :3].T @ other["F"][:3], X[:3, :3].T @ other["F"][3:]])
    np.testing.assert_allclose(back, one["F"], atol=1e-9)
    assert other["U"] == pytest.approx(one["U"], abs=1e-12)
    assert other["gap"] == pytest.approx(one["gap"], abs=1e-12)


# ---- invalid fixtures


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fixture(plane(), "guard"), "no role 'guard'; there are: guide, forbid"),
        (lambda: fixture(plane(), law="glue"), "no law 'glue'; there are: spring"),
        (lambda: fixture(plane(), law_={"K": -1.0}), "law.K = -1.0.*must be 0 N/m or more"),
        (lambda: fixture(plane(), law="admittance", law_={"ratio": 0.0}), "law.ratio = 0.0.*policy `hard`"),
        (lambda: fixture(plane(), "orient", role_={"target": "up"}), "role.target = 'up': must be axis, normal"),
        (
            lambda: _guidance.Fixtures([fixture(sphere(), "orient")]),
            "orient with target axis.*has one; turn it .rpy_deg.",
        ),
        (lambda: _guidance.Fixtures([fixture(plane(), authority=1.5)]), "'one'.authority = 1.5.*0..1"),
        (lambda: _guidance.Fixtures([fixture(plane(), rise=0.0)]), "'one'.rise = 0.0.*no steps"),
        (lambda: _guidance.Fixtures([fixture(plane(), engage=0.02, release=0.01)]), "release = 0.01.*below engage"),
        (lambda: _guidance.Fixtures([fixture(plane()), fixture(plane())]), "two fixtures are named 'one'"),
        (lambda: _guidance.Fixtures([fixture(plane(), ramps=[_core.Ramp("time", 1.0, 1.0)])]), "ramp.*not the same"),
        (lambda: _core.Ramp("mood"), "a ramp goes by 'pedal', 'distance', 'time' or 'force'; got 'mood'"),
    ],
)
def test_invalid_fixtures_are_reported(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_options_are_read_back():
    policy = filled(_core.Policy(), {"priority": 3, "ramps": [_core.Ramp("force", 4.0, 2.0)]})
    f = fixture(plane(), hard=True, ramps=policy.ramps, priority=policy.priority)
    assert (f.policy.hard, f.policy.priority, f.policy.ramps[0].by, f.policy.ramps[0].end) == (True, 3, "force", 2.0)
