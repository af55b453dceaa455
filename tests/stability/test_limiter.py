"""The force limiter: safe forces pass unchanged, and unsafe ones are limited."""

import math

import numpy as np
import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core, _verify

CAP, RATE, STALE = 3.0, 50.0, 0.03
LEADER_STALE, FOLLOWER_STALE, NOT_FINITE, FORCE_CAPPED, RATE_CAPPED = 4, 8, 16, 1, 2


def limiter(dt=1e-3, **options):
    o = _core.StabilityOptions()
    for name, value in options.items():
        setattr(o, name, value)
    return _verify.Limiter(o, dt)


def test_defaults_are_the_documented_ones():
    o = _core.StabilityOptions()
    assert (o.force_cap, o.rate_cap, o.stale_after) == (CAP, RATE, STALE)


anything = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(-10, 10),
    st.sampled_from([1e308, -1e308, 1e-320, math.nan, math.inf, -math.inf, 0.0]),
)
tick = st.fixed_dictionaries(
    {
        "F_H_L": st.tuples(anything, anything, anything).map(np.array),
        "t": anything,
        "t_leader": anything,
        "t_follower": anything,
        "leader_valid": st.booleans(),
        "follower_valid": st.booleans(),
        "engaged": st.booleans(),
    }
)


@settings(max_examples=examples(400), deadline=None)
@given(ticks=st.lists(tick, max_size=40), dt=st.sampled_from([2.5e-4, 1e-3, 4e-3, 1e-2]))
def test_output_is_safe_for_any_input(ticks, dt):
    m, last = limiter(dt), np.zeros(3)
    for t in ticks:
        F, _, _ = m.step(**t)
        assert np.isfinite(F).all()
        assert np.linalg.norm(F) <= CAP
        assert np.linalg.norm(F - last) <= RATE * dt
        last = F


@settings(max_examples=examples(200), deadline=None)
@given(forces=st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 3).map(np.array), min_size=1, max_size=60))
def test_trusted_forces_are_safe_too(forces):
    """The same with valid states only, so that the limits act."""
    m, last = limiter(), np.zeros(3)
    for F_in in forces:
        F, cut, _ = m.step(F_in)
        assert np.linalg.norm(F) <= CAP
        assert np.linalg.norm(F - last) <= RATE * 1e-3
        np.testing.assert_allclose(F + cut, F_in, atol=1e-9)
        last = F


def test_forces_within_the_limits_are_unchanged():
    m = limiter()
    for k in range(2000):
        F_in = 2.9 * np.sin(0.01 * k) * np.array([0.6, 0.0, 0.8])  # at most 29 N/s
        F, cut, status = m.step(F_in)
        np.testing.assert_array_equal(F, F_in)
        assert status == 0
        assert not cut.any()


def test_cap_keeps_the_direction():
    m = limiter()
    requested = np.array([3.0, -6.0, 9.0])
    for _ in range(200):
        F, _, status = m.step(requested)
    assert np.linalg.norm(F) == pytest.approx(CAP, rel=1e-9)
    np.testing.assert_allclose(np.cross(F, requested), 0, atol=1e-9)
    assert status == FORCE_CAPPED


def test_step_becomes_a_ramp_at_the_rate_cap():
    m = limiter()
    norms = [np.linalg.norm(m.step(np.array([0, 2.0, 0]))[0]) for _ in range(60)]
    np.testing.assert_allclose(norms, np.minimum(0.05 * np.arange(1, 61), 2.0), rtol=1e-9)


@pytest.mark.parametrize(
    ("fault", "bit"),
    [
        ({"t_leader": -0.031}, LEADER_STALE),
        ({"t_leader": 0.031}, LEADER_STALE),
        ({"t_follower": -0.031}, FOLLOWER_STALE),
        ({"t_follower": math.nan}, FOLLOWER_STALE),
        ({"leader_valid": False}, LEADER_STALE),
        ({"follower_valid": False}, FOLLOWER_STALE),
        ({"engaged": False}, 0),
        ({"F_H_L": np.array([0, math.nan, 1.0])}, NOT_FINITE),
    ],
)
def test_watchdog_ramps_to_zero_and_recovers_by_the_same_ramp(fault, bit):
    m, valid = limiter(), np.array([0.0, 0.0, 2.0])
    for _ in range(100):
        F, _, _ = m.step(valid)
    np.testing.assert_array_equal(F, valid)
    down = []
    for _ in range(60):
        F, _, status = m.step(**({"F_H_L": valid} | fault))
        down.append(np.linalg.norm(F))
        assert status & ~RATE_CAPPED == bit
    np.testing.assert_allclose(down, np.maximum(2.0 - 0.05 * np.arange(1, 61), 0.0), atol=1e-9)
    assert down[-1] == 0.0  # exactly zero
    up = [np.linalg.norm(m.step(valid)[0]) for _ in range(60)]
    np.testing.assert_allclose(up, np.minimum(0.05 * np.arange(1, 61), 2.0), atol=1e-9)


def test_states_at_the_age_limit_are_accepted():
    assert limiter().step(np.array([0.01, 0, 0]), t=1.0, t_leader=0.9701, t_follower=0.9701)[2] == 0


@pytest.mark.parametrize(
    ("name", "value"), [("force_cap", -1.0), ("force_cap", math.inf), ("rate_cap", 0.0), ("stale_after", math.nan)]
)
def test_invalid_options_are_reported(name, value):
    with pytest.raises(ValueError, match=f"stability.{name}"):
        limiter(**{name: value})
