"""Simulated operators: their parameters, and their closed loop against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from palpate.operators import STEP, TRAITS, Aim, Errand, Operator, Person, Senses, cohort, perform
from palpate.record.ticks import TICK, TICK_DOUBLES

SCALE = 0.5


class Glass:
    """A simulation without mass, friction and lag: the tool is at the commanded point and presses below z = 0."""

    def __init__(self, start, stiffness=0.0, wind=(0.0, 0.0, 0.0), yielding=0.0):
        self.hand, self.start, self.k = np.zeros(3), np.array(start, float), 0
        self.wind, self.yielding, self.stiffness = np.array(wind, float), yielding, stiffness

    def run(self, n, hand_W=None):
        rows = np.zeros(n, dtype=TICK)
        led = np.tile(self.hand, (n, 1)) if hand_W is None else np.asarray(hand_W)
        rows["t"] = (self.k + np.arange(n)) / 1000
        rows["p_WT"] = self.start + SCALE * led
        rows["depth"] = np.maximum(-rows["p_WT"][:, 2], 0.0)
        rows["F_H_L"] = self.wind
        self.hand, self.k = led[-1], self.k + n
        return rows.view(np.float64).reshape(n, TICK_DOUBLES)


def calm(**changes) -> Person:
    """A person without errors, noise or haste, with median delays and gains."""
    quiet = dict.fromkeys(("visual_error", "noise", "unrest", "tremor", "weber", "sight_of_force"), 0.0)
    values = {name: trait.median for name, trait in TRAITS.items()} | quiet | {"haste": 1.0, "yields": 0.0} | changes
    return replace(cohort(1)[0], **values)


def line(length=0.04, press=0.0, stiffness=400.0):
    path = np.linspace([0, 0, 0], [length, 0, 0], 81)
    return Errand(path, np.full(81, 0.004), stiffness, press)


def done(person, errand, senses=None, sim=None, start=(0.0, 0.0, 0.0), most=10.0, seed=1):
    return perform(sim or Glass(start), Operator(person, senses or Senses(), seed), errand, np.eye(4), SCALE, most)


def test_every_trait_names_its_source():
    for name, trait in TRAITS.items():
        assert trait.median > 0.0, name
        assert trait.factor >= 1.1, name
        assert len(trait.source) > 20, name
        assert any(year in trait.source for year in map(str, range(1950, 2027))) or "ours" in trait.source, name


def test_cohort_is_reproducible_and_independent_of_its_size():
    assert cohort(5, seed=3) == cohort(9, seed=3)[:5]
    assert cohort(5, seed=3) != cohort(5, seed=4)


def test_cohort_scatters_as_its_traits_state():
    people = cohort(400)
    for name, trait in TRAITS.items():
        values = np.array([getattr(person, name) for person in people])
        if name == "haste":
            assert values.min() >= 1.0
            continue
        assert np.median(values) == pytest.approx(trait.median, rel=0.1), name
        inside = (values < trait.median * trait.factor) & (values > trait.median / trait.factor)
        assert inside.mean() == pytest.approx(0.95, abs=0.04), name


def test_operator_without_error_and_noise_follows_the_line():
    trial = done(calm(), line())
    assert trial.done
    assert np.abs(trial.p_WT[:, 1:]).max() < 1e-9


def test_time_matches_the_steering_law():
    """T = pace L / W, until the hand decelerates before the end."""
    person = calm(pace=0.3)
    trial = done(person, line(0.04))
    arrived = trial.t[np.argmax(trial.p_WT[:, 0] > 0.030)]
    assert arrived == pytest.approx(0.3 * 0.030 / 0.004, rel=0.2)


def test_visible_error_decays_as_in_the_crossover_model():
    """For small gain * delay e' = -gain e decays within a second; near gain * delay = pi/2 it never settles."""
    start = (0.0, 0.002, 0.0)
    e = done(calm(visual_gain=3.0), line(0.2), sim=Glass(start), most=2.0).p_WT[:, 1]
    assert abs(e[-1]) < 0.02 * 0.002
    wild = done(calm(visual_gain=9.0, visual_delay=0.2), line(0.2), sim=Glass(start), most=4.0).p_WT[:, 1]
    assert np.abs(wild[-250:]).max() > 0.002


@pytest.mark.parametrize("force", ["felt", "shown", "looks"])
def test_target_force_is_reached(force):
    trial = done(calm(), line(0.05, press=0.5), Senses(force), Glass((0, 0, 0.0005)), most=6.0)
    error = 0.25 if force == "shown" else 0.03  # the displayed bar is read with an error
    assert trial.F_T[-100:].mean() == pytest.approx(0.5, rel=error)


def test_unfelt_force_has_one_bias_per_trial():
    person = calm(sight_of_force=0.35)
    ends = [done(person, line(0.05, press=0.5), Senses(), seed=s, most=6.0).F_T[-50:].mean() for s in range(8)]
    felt = [done(person, line(0.05, press=0.5), Senses("felt"), seed=s, most=6.0).F_T[-50:].mean() for s in range(2)]
    assert np.ptp(np.log(ends)) > 0.3
    assert np.ptp(felt) < 0.01


def test_operator_yields_only_to_forces_above_the_threshold():
    """The hand yields at the rate yields F / k, and not at all below the threshold of perception."""
    person = calm(yields=1.0, visual_gain=0.0, threshold=0.05)
    pushed = done(person, line(0.1), sim=Glass((0, 0, 0), wind=(0.0, 0.5, 0.0)), most=2.0)
    speed = np.gradient(pushed.p_WT[:, 1], pushed.t)[-50:].mean()
    assert speed == pytest.approx(SCALE * (0.5 - 0.05) / person.hand.stiffness, rel=0.02)
    unfelt = done(person, line(0.1), sim=Glass((0, 0, 0), wind=(0.0, 0.04, 0.0)), most=1.0)
    assert np.abs(unfelt.p_WT[:, 1]).max() < 1e-9


def test_displayed_path_halves_the_visual_error():
    person = calm(visual_error=0.5e-3)
    looks = [Operator(person, Senses(drawn=drawn), 4)._sight_error for drawn in (False, True)]
    np.testing.assert_allclose(looks[1], 0.5 * looks[0])
    assert STEP == 0.02


def aim(error=(0.0, 0.0, 0.0), width=0.004, **changes):
    """A goal far from the end of a path along x."""
    given = {"press": 0.0, "into": np.array([0.0, 0.0, -1.0]), "stiffness": 400.0} | changes
    return Aim(np.array(error), np.array([1.0, 0.0, 0.0]), 1.0, width, **given)


def led(person, goal, updates=1400, seed=1, scale=SCALE, senses=None):
    """Velocities of the hand (n, 3) [m/s] for a constant goal, after the lag of the muscles."""
    operator = Operator(person, senses or Senses(), seed)
    at = np.zeros(3)
    return np.array([operator.lead(at, 0.0, at, goal, scale) for _ in range(updates)])[100:]


def test_depth_scales_the_error_along_the_line_of_sight():
    """The camera looks along y of W: `TRAITS["depth"]` is the error along y per error across it, on each trial."""
    person = calm(visual_error=0.4e-3, depth=2.5)
    seen = []
    for seed in range(40):
        operator = Operator(person, Senses(), seed)
        for _ in range(300):
            operator.lead(np.zeros(3), 0.0, np.zeros(3), aim(), SCALE)
            seen.append(operator.x)
    x, y, z = np.std(seen, axis=0)
    assert x == pytest.approx(0.4e-3, rel=0.1)
    assert z == pytest.approx(0.4e-3, rel=0.1)
    assert y == pytest.approx(2.5 * 0.4e-3, rel=0.1)


@pytest.mark.parametrize(("noise", "pace"), [(0.15, 0.4), (0.3, 0.4), (0.3, 0.8)])
def test_motor_noise_is_the_trait_times_the_intended_speed(noise, pace):
    """Reference: noise with correlation time c behind a lag l has the rms sqrt(c / (c + l)), here 0.15 s and 0.08 s."""
    v = np.concatenate([led(calm(noise=noise, pace=pace), aim(), seed=k) for k in range(12)])
    intended = 0.004 / pace / SCALE
    rms = np.sqrt(np.mean((v - [intended, 0.0, 0.0]) ** 2, axis=0))
    np.testing.assert_allclose(rms, noise * intended * np.sqrt(0.15 / 0.23), rtol=0.12)


def test_unrest_does_not_depend_on_the_intended_speed():
    v = np.concatenate([led(calm(unrest=1e-3), aim(), seed=k) for k in range(12)])
    rms = np.sqrt(np.mean((v - v.mean(axis=0)) ** 2, axis=0))
    np.testing.assert_allclose(rms, 1e-3 * np.sqrt(0.15 / 0.23), rtol=0.12)


@pytest.mark.parametrize(
    ("error", "care"), [(0.0, 1.0), (0.25, 0.75), (0.5, 0.5), (0.75, 0.25), (1.0, 0.2), (3.0, 0.2)]
)
def test_care_slows_the_hand_in_proportion_to_the_seen_error(error, care):
    """`error` is per half of the width; at the border a fifth of the speed of the steering law is left."""
    person = calm(pace=0.4, visual_gain=0.0)
    for direction in (1.0, -1.0):
        v = led(person, aim((0.0, direction * error * 0.002, 0.0)), updates=200)
        np.testing.assert_allclose(v[-1], [care * 0.004 / 0.4 / SCALE, 0.0, 0.0], rtol=1e-6, atol=1e-12)


def test_speed_along_a_wide_passage_is_limited():
    v = led(calm(pace=0.1), aim(width=0.02), updates=300)
    assert v[-1][0] * SCALE == pytest.approx(0.03, rel=1e-6)


def test_the_hand_slows_down_before_the_end_of_the_path():
    """The rest of the path would take 0.3 s at any time."""
    v = led(calm(pace=0.4), replace(aim(), ahead=0.0015), updates=300)
    assert v[-1][0] * SCALE == pytest.approx(0.0015 / 0.3, rel=1e-6)
