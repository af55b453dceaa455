"""Rate control at the rim and drift: closed forms, bounds, continuity, and energy against elastic surfaces."""

import numpy as np
import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core

DT = 1e-3
SIZE = np.array([0.2, 0.1, 0.1])  # workspace [m]
SCALE = 0.5


def make(law, R_WL=None, **values):
    o, r = _core.MappingOptions(), _core.RecentringOptions()
    r.law, r.workspace, r.centre = getattr(_core.MappingLaw, law), SIZE, np.zeros(3)
    for name, value in values.items():
        setattr(r, name, value)
    o.recentring, o.scale = r, SCALE
    return _core.Mapping(o, np.eye(3) if R_WL is None else R_WL, DT)


class Hand:
    """Moves the handle of a mapping; the axes of L and W are parallel unless R_WL turns them."""

    def __init__(self, m, start=(0, 0, 0), R_WL=None):
        self.m, self.p, self.R = m, np.array(start, float), np.eye(3) if R_WL is None else R_WL
        self.tool = np.zeros(3)

    def to(self, p, F=(0, 0, 0), **kwargs):
        """One tick with the handle at p; returns the tool goal."""
        v, self.p = (np.asarray(p) - self.p) / DT, np.asarray(p, float)
        X_WH, X_WT = np.eye(4), np.eye(4)
        X_WH[:3, 3], X_WT[:3, 3] = self.R @ self.p, self.tool
        goal, *_ = self.m.step(X_WH, v, 0.0, X_WT, p_LH=self.p, F_T_W=np.asarray(F, float), **kwargs)
        self.tool = goal[:3, 3]
        return self.tool


def hold(m, p, ticks=2000, **kwargs):
    hand = Hand(m, p)
    return np.array([hand.to(p, **kwargs) for _ in range(ticks)])


@pytest.mark.parametrize(("u", "share"), [(0.5, 0.0), (0.7, 0.0), (0.85, 0.25), (1.0, 1.0), (1.4, 1.0)])
def test_rate_control_has_the_speed_of_its_law(u, share):
    """rim_speed ((u - rim) / (1 - rim))^2, outwards, once it has started."""
    path = hold(make("rate", rim=0.7, rim_speed=0.04), [0.5 * SIZE[0] * u, 0, 0])
    np.testing.assert_allclose((path[-1] - path[-2]) / DT, [0.04 * share, 0, 0], atol=1e-12)


def test_the_rim_is_an_ellipsoid_in_the_axes_of_the_device():
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # x of the device is y of the world
    hand = Hand(make("rate", R, rim=0.0), [0.5 * SIZE[0], 0, 0], R)
    path = np.array([hand.to([0.5 * SIZE[0], 0, 0]) for _ in range(1000)])
    np.testing.assert_allclose((path[-1] - path[-2]) / DT, [0, 0.05, 0], atol=1e-12)
    inner = hold(make("rate", rim=0.6), [0.5 * SIZE[1], 0, 0])  # 1 along y is 0.5 along x
    assert not (inner[-1] - inner[0]).any()


def test_rate_control_changes_its_velocity_no_faster_than_stated():
    """Reaches rim_speed in 0.1 s, also after the clutch, when it starts from rest."""
    hand = Hand(make("rate", rim_speed=0.05), [0.1, 0, 0])
    path = [hand.to([0.1, 0, 0], clutch=300 <= k < 320) for k in range(700)]
    v = np.diff(path, axis=0) / DT
    stopped = slice(299, 319)
    assert not v[stopped].any()
    assert np.linalg.norm(v, axis=1).max() <= 0.05 + 1e-12
    assert np.linalg.norm(np.diff(v[319:], axis=0), axis=1).max() <= 0.05 / 0.1 * DT + 1e-12


def test_drift_has_the_closed_form_of_its_law():
    """Moving from e0 to e1 along x the drift is scale k / h (e1^2 - e0^2) / 2 for the half-length h, without rest."""
    m, h, k, v = make("drift", drift=0.3), 0.5 * SIZE[0], 0.3, 0.2
    x = np.arange(0.01, 0.09, v * DT)
    hand = Hand(m, [x[0], 0, 0])
    path = np.array([hand.to([e, 0, 0]) for e in x])
    drift = path[-1, 0] - path[0, 0] - SCALE * (x[-1] - x[0])
    kept = 1 - 0.005 / (SCALE * v)  # 5 mm/s count as rest
    assert drift == pytest.approx(kept * SCALE * k / h * (x[-1] ** 2 - x[0] ** 2) / 2, rel=0.01)


@pytest.mark.parametrize("noise", [0.0, 0.0005])
def test_a_resting_hand_does_not_drift(noise):
    rng = np.random.default_rng(3)
    m = make("drift")
    X = np.eye(4)
    for _ in range(1000):
        goal, *_ = m.step(X, rng.normal(0, noise, 3), 0.0, X, p_LH=np.array([0.08, 0, 0]))
    np.testing.assert_allclose(goal[:3, 3], 0, atol=1e-15)


def test_a_hand_that_follows_a_target_returns_to_the_centre():
    """The person keeps the tool on a circle: the middle of the hand's motion decays with the length of the way."""
    m, k, h, radius, speed = make("drift", drift=0.3), 0.3, 0.05, 0.01, 0.2
    hand, offset = Hand(m, [0, 0.04, 0]), np.array([0, 0.04, 0])
    t = np.arange(0, 6, DT)
    target = SCALE * radius * np.stack([np.cos(speed / radius * t) - 1, np.sin(speed / radius * t), 0 * t], axis=1)
    p = offset.copy()
    middles = []
    for wanted in target:
        tool = hand.to(p)
        p = p + (wanted - tool) / SCALE
        middles.append(p - wanted / SCALE)
    way = (speed - 0.005 / SCALE) * t[-1]
    final = np.mean(np.array(middles)[-3000:, 1])
    assert abs(final) < 0.2 * 0.04
    assert abs(final) < 0.04 * np.exp(-0.5 * k * way / h)


@pytest.mark.parametrize("law", ["rate", "drift"])
def test_the_tool_waits_while_the_follower_does_not_reach_its_goal(law):
    m = make(law)
    hand = Hand(m, [0.09, 0, 0])
    hand.to([0.09, 0, 0])
    before = hand.tool.copy()
    for k in range(500):
        p = np.array([0.09 + 0.005 * np.sin(0.05 * k), 0, 0])
        hand.to(p, reached=False)
    np.testing.assert_allclose(hand.tool - before, SCALE * (p - [0.09, 0, 0]), atol=1e-12)


@settings(max_examples=examples(40), deadline=None)
@given(st.sampled_from(["rate", "drift"]), st.integers(0, 2**32 - 1))
def test_the_tool_never_jumps_and_its_own_speed_is_bounded(law, seed):
    """Whatever hand, pedals, forces and irregular times: the goal moves as the hand plus the bound of the law."""
    rng = np.random.default_rng(seed)
    m, p, t, last = make(law), rng.uniform(-0.1, 0.1, 3), 0.0, None
    hand = Hand(m, p)
    for _ in range(300):
        dp = rng.normal(0, 2e-4, 3)
        dt = rng.choice([0.0, 2.5e-4, DT, 3e-3, 0.5])
        t, clutch = t + dt, bool(rng.random() < 0.05)
        goal = hand.to(hand.p + dp, rng.normal(0, 2, 3), clutch=clutch, following=rng.random() > 0.02, t=t)
        own = 0.05 if law == "rate" else 0.2 * SCALE * np.linalg.norm(dp) / DT
        if last is not None:
            most = SCALE * np.linalg.norm(dp) + own * min(dt, 3 * DT)
            assert np.linalg.norm(goal - last) <= most + 1e-12
        last = goal


# -- energy ------------------------------------------------------------------------------------------------------------

K = 600.0  # stiffness of the wall and of the ball [N/m]


def wall(p):
    """Force and energy of an elastic floor at z = -5 mm."""
    d = min(p[2] + 0.005, 0.0)
    return np.array([0, 0, -K * d]), 0.5 * K * d * d


def ball(p):
    """Force and energy of an elastic ball of 20 mm whose surface is 5 mm below the start."""
    r = p - [0, 0, -0.025]
    away = np.linalg.norm(r)
    d = min(away - 0.02, 0.0)
    return -K * d * r / away, 0.5 * K * d * d


def energies(law, surface, seed, sees_force=True):
    """Energy that the hand got, stored energy, and energy that the mapping released [J], over 4 s of motion."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 4, DT)[:, None]
    amplitude, phase, f = rng.uniform(0.01, 0.05, (4, 3)), rng.uniform(0, 6, (4, 3)), rng.uniform(0.1, 2, (4, 3))
    x = sum(a * np.sin(2 * np.pi * w * t + b) for a, b, w in zip(amplitude, phase, f, strict=True))
    x -= x[0]
    m = make(law)
    hand, F, last, got, released = Hand(m), np.zeros(3), None, 0.0, 0.0
    for p in x:
        tool = hand.to(p, F if sees_force else np.zeros(3))
        released += m.released / SCALE
        F, stored = surface(tool)
        if last is not None:
            got += 0.5 * (last[1] + F) @ (p - last[0])  # exact for a linear spring
        last = (p, F)
    return got, stored / SCALE, released


SECOND_ORDER = 2e-4  # [J] 1/2 K |v dt|^2 of each tick along surfaces that bend, and edges of contact within a tick


@pytest.mark.parametrize("surface", [wall, ball])
@pytest.mark.parametrize("law", ["rate", "drift", "position"])
def test_no_energy_is_generated_and_the_ledger_closes(law, surface):
    for seed in range(3):
        got, stored, released = energies(law, surface, seed)
        assert got <= SECOND_ORDER
        assert released >= 0.0
        assert -got == pytest.approx(stored + released, abs=SECOND_ORDER)


def test_what_the_mapping_releases_is_force_times_its_own_way():
    m = make("rate", rim_speed=0.05)
    hand = Hand(m, [0.1, 0, 0])
    before = hand.to([0.1, 0, 0], F=[1.0, -2.0, 0.5])[0]
    sums = 0.0
    for _ in range(400):
        tool = hand.to([0.1, 0, 0], F=[1.0, -2.0, 0.5])
        sums += m.released
    assert sums == pytest.approx(tool[0] - before)
    assert sums > 0.01
    hand.to([0.1, 0, 0], F=[1.0, -2.0, 0.5], clutch=True)
    assert m.released == 0.0


@pytest.mark.parametrize("law", ["rate", "drift"])
def test_the_energy_judge_finds_a_mapping_that_presses(law):
    """Without the force the tool is pressed into the wall by itself: the hand gets energy out of nothing."""
    assert max(energies(law, wall, seed, sees_force=False)[0] for seed in range(6)) > 10 * SECOND_ORDER


def test_a_hard_fixture_holds_the_tool_back():
    m = make("rate")
    hand = Hand(m, [0.1, 0, 0])
    for _ in range(500):
        goal = hand.to([0.1, 0, 0], correction_W=np.array([-1e-3, 0, 0]))
    np.testing.assert_allclose(goal, 0, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("workspace", np.array([0.1, 0.0, 0.1]), "workspace"),
        ("workspace", np.array([0.1, np.nan, 0.1]), "workspace"),
        ("centre", np.array([np.inf, 0, 0]), "centre"),
        ("rim", 1.0, "rim"),
        ("rim_speed", 2.0, "rim_speed"),
        ("drift", 1.0, "drift"),
    ],
)
def test_invalid_options_are_named(name, value, told):
    with pytest.raises(ValueError, match=f"mapping.{told} = "):
        make("rate", **{name: value})
