"""The judge of oscillations against closed forms of motions and against the eigenvalues of the sampled delayed loop."""

import itertools
from types import SimpleNamespace

import json_contract
import numpy as np
import pytest

from palpate import _verify
from palpate_lab.studies.certificate import swings

DT = 1e-3
FLOOR = 1e-6  # amplitude that counts as rest [m]


def crossings(x, floor=FLOOR):
    """The rule that `judge_swing` replaces: four upward crossings in the last quarter, not every eighth quieter."""
    late = x[len(x) - len(x) // 4 :]
    upward = np.count_nonzero((late[:-1] < late.mean()) & (late[1:] >= late.mean()))
    eighths = [np.ptp(x[i * len(x) // 8 : (i + 1) * len(x) // 8]) for i in range(3, 8)]
    decays = all(b <= 0.998 * a for a, b in itertools.pairwise(eighths))
    return bool(upward >= 4 and 0.5 * np.ptp(late) > floor and not decays)


def sine(t, f, growth=0.0, size=2e-3):
    return size * np.exp(growth * t) * np.sin(2 * np.pi * f * t + 0.3)


def one_sided(t, f, growth=0.0):
    """A stiff wall on one side: excursions out of it are twenty times as large."""
    s = np.sin(2 * np.pi * f * t)
    return 4e-3 * np.exp(growth * t) * np.where(s > 0.0, 0.05 * s, s)


def beating(t, f, g, growth=0.0):
    return sine(t, f, growth) + 0.6 * sine(t + 0.1, g, growth)


T2, T6, T20 = (np.arange(0.0, T, DT) for T in (2.0, 6.0, 20.0))

# name: motion, slowest period, verdict, verdict of the former rule
MOTIONS = {
    "slow, 0.5 Hz": (sine(T20, 0.5), 2.0, "lasts", False),
    "slow, 2 Hz in 6 s": (sine(T6, 2.0), 0.5, "lasts", False),
    "slow, 3 Hz in 2 s": (sine(T2, 3.0), 1 / 3, "lasts", False),
    "slow and growing": (sine(T6, 1.5, 0.4), 1 / 1.5, "lasts", False),
    "growing": (sine(T6, 8.0, 0.4), 1 / 8.0, "lasts", True),
    "constant": (sine(T6, 8.0), 1 / 8.0, "lasts", True),
    "fast, 50 Hz": (sine(T2, 50.0), 0.3, "lasts", True),
    "fast, 400 Hz": (sine(T2, 400.0, size=2e-5), 0.02, "lasts", True),
    "fast and growing": (sine(T2, 137.0, 0.2), 0.1, "lasts", True),
    "slower than the mode that is named": (sine(T20, 1.0), 0.05, "lasts", True),
    "slow, one-sided": (one_sided(T6, 2.0), 0.4, "lasts", False),
    "one-sided and growing": (one_sided(T2, 3.0, 0.3), 1 / 3, "lasts", False),
    "one-sided and decaying": (one_sided(T6, 6.0, -0.3), 1 / 6, "decays", False),
    "beating": (beating(T6, 10.0, 11.0), 0.1, "lasts", True),
    "beating and growing": (beating(T6, 10.0, 11.0, 0.1), 0.1, "lasts", True),
    "beating and decaying": (beating(T20, 10.0, 11.0, -0.12), 0.1, "decays", False),
    "slowly beating and decaying": (beating(T20, 8.0, 8.2, -0.1), 1 / 8, "decays", True),
    "decaying slowly": (sine(T20, 2.0, -0.02), 0.5, "decays", False),
    "fast, decaying slowly": (sine(T6, 400.0, -0.02), 0.1, "decays", False),
    "decaying fast": (sine(T6, 5.0, -4.0), 0.2, "rests", False),
    "a limit cycle after a transient": (sine(T20, 2.0) + sine(T20, 7.0, -3.0, 0.05), 0.5, "lasts", True),
    "creeping": (3e-3 - 2e-3 * np.exp(-0.2 * T6), 0.2, "decays", False),
    "falling": (0.01 * T6**2, 0.2, "decays", False),
    "at rest": (np.full(2000, 4e-3), 0.2, "rests", False),
    "two periods": (sine(T2, 1.0), 1.0, "undecided", False),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_closed_forms_of_motions(name):
    x, period, verdict, former = MOTIONS[name]
    assert _verify.judge_swing(x, DT, period, FLOOR).swing == verdict
    assert crossings(x) == former


def test_the_former_rule_was_wrong_about_slow_and_beating_motions():
    wrong = {name for name, (_, _, verdict, former) in MOTIONS.items() if former != (verdict == "lasts")}
    assert {"slow, 0.5 Hz", "slow and growing", "slow, one-sided", "slowly beating and decaying"} <= wrong
    assert not wrong & {"constant", "growing", "fast, 400 Hz", "beating", "at rest"}


@pytest.mark.parametrize("f", [0.5, 3.0, 40.0])
@pytest.mark.parametrize("growth", [-0.08, 0.0, 0.15])
def test_growth_is_that_of_the_envelope(f, growth):
    t = np.arange(0.0, 32 / f, DT)
    assert _verify.judge_swing(sine(t, f, growth), DT, 1 / f, FLOOR).growth == pytest.approx(growth, abs=2e-3)


def test_chatter_of_encoder_counts_is_rest_up_to_the_floor():
    count, rng = 1e-5, np.random.default_rng(0)
    floor = _verify.AXIS_QUANTA * count
    for most in (1, 2, 8):
        x = count * rng.integers(-most, most + 1, 4000)
        assert _verify.judge_swing(x, DT, 0.1, floor).swing == "rests"
    assert _verify.judge_swing(count * np.round(12 * np.sin(80 * T2)), DT, 0.1, floor).swing == "lasts"


# K 1400 N/m, B 1 N s/m, 0.5 kg, a hand of 0.1 kg, 2 N s/m and 250 N/m that pushes with 2 N
def pressed(K, delay, **values):
    o = _verify.AxisOptions()
    o.mass, o.K, o.B, o.delay = 0.5, K, 1.0, delay
    o.hand_mass, o.hand_damping, o.hand_stiffness = 0.1, 2.0, 250.0
    for name, value in values.items():
        setattr(o, name, value)
    return _verify.Axis(o)


@pytest.mark.parametrize("K", [1000.0, 1400.0, 1800.0])
@pytest.mark.parametrize("delay", [2e-3, 3e-3, 5e-3, 7e-3, 10e-3])
def test_a_wall_that_swings_with_little_delay_swings_with_more(K, delay):
    """The amplitude rises with the delay, from 1 mm to over 100 mm. The former rule missed ten of the fourteen."""
    axis = pressed(K, delay)
    short, rows = axis.trace(duration=2.0, push=2.0)
    swings = (K, delay) != (1000.0, 2e-3)
    assert short.oscillates == axis.run(push=2.0).oscillates == swings
    assert crossings(rows[:, 1]) == (delay <= 3e-3 and swings and (K, delay) != (1800.0, 3e-3))


def test_a_cap_on_the_force_makes_growth_a_limit_cycle():
    free, capped = (pressed(1400.0, 5e-3, bilateral=True, force_max=cap) for cap in (np.inf, 3.0))
    assert free.run(v0=0.02).growth > 1.0
    result = capped.run(duration=20.0, v0=0.02)
    assert result.swing == "lasts"
    assert abs(result.growth) < 0.01


def test_a_run_is_as_long_as_its_slowest_mode_and_its_path_need():
    still = pressed(1400.0, 2e-3, hand_damping=20.0).run(push=2.0)
    assert still.swing == "rests"
    assert still.duration == pytest.approx(4 * 2 * np.pi * np.sqrt(0.6 / 250.0), abs=1e-2)
    moved = pressed(1400.0, 2e-3, hand_damping=20.0).run(path=[*np.linspace(-0.01, 0.01, 1500).tolist(), 0.01, 0.01])
    assert moved.duration == pytest.approx(still.duration + 1.5, abs=1e-2)
    slowly = pressed(300.0, 0.0, hand_damping=0.05, damping=0.0, bilateral=True, B=0.0).run(v0=0.1)
    assert slowly.swing == "lasts" or slowly.duration > 16 * 0.18  # asked again while it only decays


def test_growing_and_decaying_loops_are_told_apart_by_the_eigenvalues():
    """Loops that grow or decay by less than 1 % in the watched time are left out: one in a hundred or fewer."""
    unstable, watched = 0, 0
    for seed in range(120):
        o = swings.linear(np.random.default_rng([4, seed]))
        growth, result = swings.growth(o), _verify.Axis(o).run(push=1.0, v0=0.1)
        if abs(growth) * 0.75 * result.duration < swings.UNCLEAR:
            continue
        watched += 1
        unstable += growth > 0.0
        assert result.oscillates == (growth > 0.0)
        if result.swing == "lasts" and not result.diverged and growth < 3.0:
            assert result.growth == pytest.approx(growth, rel=0.1, abs=0.02)
    assert watched > 110
    assert 20 < unstable < 100


def test_random_loops_lie_around_their_limit():
    """Four in ten within 10 % of the stiffness at which the largest eigenvalue leaves the unit circle."""
    near, shares = 0, []
    for seed in range(40):
        o = swings.linear(np.random.default_rng([5, seed]))
        K = o.K
        below, above = (swings.growth(o) for o.K in (0.85 * K, 1.15 * K))
        near += below < 0.0 < above
        shares.append((o.rate, o.delay))
    assert 10 <= near <= 24
    assert {rate for rate, _ in shares} == {250.0, 1000.0, 4000.0}
    assert max(delay for _, delay in shares) <= 0.03


def test_verdicts_are_counted_by_the_sign_of_the_growth():
    def row(growth, swing, oscillates, clear=1.0):
        both = {"swing": swing, "oscillates": float(oscillates), "clear": clear}
        return {"growth_per_s": growth, **{f"{run}_{key}": v for run in swings.RUNS for key, v in both.items()}}

    rows = [row(1.0, "lasts", True), row(1.0, "undecided", False), row(0.001, "decays", False, 0.0),
            row(-1.0, "rests", False), row(-1.0, "decays", False), row(-2.0, "lasts", True)]  # fmt: skip
    swept = SimpleNamespace(rows=lambda: rows)
    found = swings.swings(6, 0, lambda *given, **more: swept)
    documented = json_contract.keys_of("study certificate", "With `--swings` the keys are")
    assert {key for run in found["runs"] for key in run} | set(found) == documented - {"needed", "short"}
    for run in found["runs"]:
        assert [run["growing"], run["growing_called"], run["growing_undecided"]] == [2, 1, 1]
        assert [run["decaying"], run["decaying_called"], run["decaying_undecided"]] == [3, 1, 0]
        assert run["agreement"] == pytest.approx(3 / 5)
    assert swings.table(found)
