"""Coulomb friction with stick and slip: the cone, a block on a belt, rest with noise, and work on closed paths."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.scene.contact import render

RADIUS, K = 2e-3, 500.0
FLOOR = _core.Mesh(
    np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32)
)


def render_path(tips, mu, mu_static=0.0, **options):
    return render(FLOOR, tips, radius=RADIUS, stiffness=K, friction=mu, static_friction=mu_static, **options)


def share(force):
    """Ratio of tangential to normal force [-]."""
    return np.linalg.norm(force[:, :2], axis=1) / force[:, 2]


def drag(depth, length, step=1e-6, direction=(0.6, 0.8)):
    """A path down to `depth` [m], then sideways by `length` [m]."""
    down = np.linspace(0.002, -depth, 100)[:, None] * [0, 0, 1] + [0, 0, RADIUS]
    along = np.arange(step, length, step)[:, None] * [*direction, 0]
    return np.concatenate([down, down[-1] + along]), len(down)


def test_sticks_until_the_static_cone_then_slips_on_the_dynamic_one():
    mu, mu_static, depth = 0.2, 0.35, 0.004
    tips, start = drag(depth, 0.003)
    force = render_path(tips, mu, mu_static).force[start:]
    x = np.linalg.norm(tips[start:, :2] - tips[start - 1, :2], axis=1)
    stuck = x < mu_static * depth - 1e-9
    np.testing.assert_allclose(force[stuck, :2], -K * (tips[start:, :2] - tips[start - 1, :2])[stuck], atol=1e-9)
    assert share(force[stuck]).max() == pytest.approx(mu_static, rel=1e-2)
    breaks_away = np.argmax(x > mu_static * depth + 1e-9)
    ticks = int(np.ceil((mu_static - mu) * K * depth / 20e-3))  # at 20 N/s
    falling = np.linalg.norm(force[breaks_away - 1 :, :2], axis=1)
    assert np.diff(falling[: ticks + 1]).min() > -20e-3 - 1e-9
    np.testing.assert_allclose(share(force[breaks_away + ticks :]), mu, rtol=1e-9)
    np.testing.assert_allclose(force[:, 2], K * depth, rtol=1e-9)


def test_breaking_away_at_rest_ends_at_the_dynamic_cone_without_creep():
    """The tool stops just after it broke away: friction falls to mu of the load at 20 N/s and stays there."""
    tips, start = drag(0.004, 0.35 * 0.004 + 2e-6)
    rest = np.repeat(tips[-1:], 500, axis=0)
    ratio = share(render_path(np.concatenate([tips, rest]), 0.2, 0.35).force[start:])
    assert np.abs(np.diff(ratio)).max() < 1.01 * 20e-3 / (K * 0.004)
    assert np.ptp(ratio[-450:]) == 0.0
    assert ratio[-1] == pytest.approx(0.2, rel=1e-9)


@pytest.mark.parametrize("mu_static", [0.0, 0.1, 0.3])
def test_static_coefficient_below_the_dynamic_one_is_raised_to_it(mu_static):
    tips, _ = drag(0.004, 0.003)
    np.testing.assert_array_equal(render_path(tips, 0.3, mu_static).force, render_path(tips, 0.3).force)


def push(friction, x, load, mu, mu_static, stiffness=5000.0):
    """Friction on a tool at x along one axis, pressed by `load` [N] onto a stiff surface: force along x."""
    lag = friction.step(np.array([x, 0, 0]), np.array([0, 0, 1.0]), load / stiffness, mu, mu_static)
    return stiffness * lag[0]


@pytest.mark.parametrize("beyond", [-0.02, 0.02])
def test_mass_on_an_incline_slides_beyond_the_static_angle_with_dynamic_friction(beyond):
    """An incline tilts slowly past the static angle: the mass starts to slide with a = g (sin - mu cos)."""
    mu, mu_static, m, g, dt = 0.2, 0.35, 0.2, 9.81, 1e-4
    friction, x, v, path = _core.Friction(), 0.0, 0.0, []
    last = np.arctan(mu_static) + beyond
    for t in np.arange(0, 1.5, dt):
        angle = min(t, 1.0) * last
        F = push(friction, x, m * g * np.cos(angle), mu, mu_static) + m * g * np.sin(angle)
        v += (F - (0.0 if friction.slipping else 5.0 * v)) / m * dt
        x += v * dt
        path.append(x)
    if beyond < 0:
        assert not friction.slipping
        assert path[-1] - path[-3000] < 1e-6
    else:
        t = np.arange(0, 0.3, dt)
        a = 2 * np.polyfit(t, path[-len(t) :], 2)[0]
        assert a == pytest.approx(g * (np.sin(last) - mu * np.cos(last)), rel=1e-2)


def test_block_on_a_belt_sticks_and_slips_with_the_analytic_period():
    """A mass m on a spring k to the wall stands on a belt at speed v. It sticks for 2 A / v, then slips back.

    With w = sqrt(k / m) and A = (mu_static - mu) N / k, slip lasts (2 pi - 2 atan(A w / v)) / w; x oscillates between
    mu N / k + sqrt(A^2 + (v / w)^2) and mu N / k - sqrt(...). The contact stiffness K adds a small compliance.
    """
    mu, mu_static, load, m, k, belt, dt = 0.2, 0.4, 2.0, 0.1, 5.0, 0.2, 5e-5
    w, A = np.sqrt(k / m), (mu_static - mu) * load / k
    friction, x, v, path, slips = _core.Friction(), 0.0, 0.0, [], []
    for t in np.arange(0, 7, dt):
        F = push(friction, x - belt * t, load, mu, mu_static) - k * x
        v += (F - (0.0 if friction.slipping else 10.0 * (v - belt))) / m * dt
        x += v * dt
        path.append(x)
        slips.append(friction.slipping)
    begins = np.flatnonzero(np.diff(np.array(slips, int)) == 1) * dt
    period = np.diff(begins)[1:]
    exact = 2 * A / belt + (2 * np.pi - 2 * np.arctan(A * w / belt)) / w
    assert len(period) >= 3
    np.testing.assert_allclose(period, exact, rtol=0.02)
    swing = np.hypot(A, belt / w)
    steady = np.array(path[len(path) // 2 :])
    assert steady.max() == pytest.approx(mu * load / k + swing, rel=0.02)
    assert steady.min() == pytest.approx(mu * load / k - swing, abs=0.02 * swing)


@pytest.mark.parametrize("slipped", [0.0, 0.0013, 0.0014, 0.003])
def test_force_at_rest_follows_only_the_noise(slipped):
    """1 um of noise on each axis: the force varies only by the spring force of the noise, in any state of rest.

    At 1.4 mm, the edge of the static cone, the noise makes the proxy slip once.
    """
    tips, start = drag(0.004, max(slipped, 2e-6))
    noise = np.random.default_rng(0).uniform(-1e-6, 1e-6, (2000, 3))
    force = render_path(np.concatenate([tips, tips[-1] + noise]), 0.2, 0.35).force[len(tips) + 20 :]
    assert (np.abs(force - force.mean(axis=0)).max(axis=0) < 1e-3).all()
    assert start > 0


def test_slow_motion_with_noise_stays_slipping():
    """Noise reverses the motion at every other tick, but a slipping proxy does not stick again because of it."""
    tips, start = drag(0.004, 0.004, step=2e-7)
    tips[start:] += np.random.default_rng(1).uniform(-1e-6, 1e-6, (len(tips) - start, 3))
    ratio = share(render_path(tips, 0.2, 0.35).force[start:])
    x = np.linalg.norm(tips[start:, :2] - tips[start - 1, :2], axis=1)
    slipping = x > 0.35 * 0.004 + 5e-6
    assert ratio[slipping].max() < 0.2 + 1e-3
    assert ratio[slipping].min() > 0.2 - 5e-3


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), mu=st.floats(0, 1), above=st.floats(0, 1))
def test_closed_paths_dissipate_energy_within_the_cone(seed, mu, above):
    rng = np.random.default_rng(seed)
    above_it = np.array([[0, 0, 0.004]])
    inside = rng.uniform(-0.004, 0.004, (7, 3)) * [1, 1, 0.5] - [0, 0, 0.002]
    knots = np.concatenate([above_it, inside, above_it])
    tips = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(knots)])
    tips[:, 2] += RADIUS
    r = render_path(tips, mu, mu + above)
    tangential = np.linalg.norm(r.force[:, :2], axis=1)
    assert (tangential <= (mu + above) * r.force[:, 2] + 1e-9).all()
    work = 0.5 * ((r.force[1:] + r.force[:-1]) * np.diff(tips, axis=0)).sum()  # work of the surface on the tool
    sampling = 0.25 * K * np.linalg.norm(np.diff(tips, axis=0), axis=1).max() * 1e-3
    assert work < sampling


def test_friction_follows_a_moving_surface():
    """The floor moves below a tool at rest and drags the tool in its direction, up to the limit of the cone."""
    n, depth = 400, 0.003
    down = np.linspace(0.002, -depth, 100)[:, None] * [0, 0, 1] + [0, 0, RADIUS]
    tips = np.concatenate([down, np.repeat(down[-1:], n, axis=0)])
    X = np.tile(np.eye(4), (len(tips), 1, 1))
    X[100:, 1, 3] = np.arange(n) * 1e-5
    force = render_path(tips, 0.3, poses=X).force[100:]
    np.testing.assert_allclose(force[:, 1], np.minimum(K * X[100:, 1, 3], 0.3 * K * depth), atol=1e-9)
