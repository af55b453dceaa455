"""Simulated operators: their parameters, and their closed loop against closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from palpate.record.ticks import TICK, TICK_DOUBLES
from palpate.simulators.operators import STEP, TRAITS, Aim, Errand, Operator, Person, Senses, cohort, perform

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


def test_page_lists_the_traits_as_they_are():
    page = Path(__file__).parents[2] / "docs" / "operators.md"
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.read_text().splitlines()]
    listed = {row[0].strip("`"): row[1:] for row in rows if row and row[0].startswith("`")}
    assert listed == {
        name: [f"{t.median:g} {t.unit}".rstrip(), f"{t.factor:g}", t.doc, t.source] for name, t in TRAITS.items()
    }


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


@pytest.mark.parametrize(("press", "part"), [(0.0, [0.0, 0.3, -0.4]), (0.5, [0.0, 0.3, 0.0])])
def test_operator_yields_across_the_path_but_not_to_the_pressed_surface(press, part):
    """The wanted force is reached, so that the hand moves along the path and gives way, and does nothing else."""
    person, goal = calm(yields=1.0, threshold=0.05), aim(press=press)
    operator = Operator(person, Senses("felt"), 1)
    v = [operator.lead(np.zeros(3), press, np.array([0.2, 0.3, -0.4]), goal, SCALE) for _ in range(200)][-1]
    yielded = (1.0 - 0.05 / np.linalg.norm(part)) * np.array(part) / person.hand.stiffness
    np.testing.assert_allclose(v, [yielded[0] + 0.03 / SCALE, *yielded[1:]], rtol=1e-6, atol=1e-9)


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


def test_without_care_the_speed_does_not_depend_on_the_seen_error():
    for error in (0.0, 0.001, 0.006):
        v = led(calm(pace=0.4, visual_gain=0.0, care=0.0), aim((0.0, error, 0.0)), updates=200)
        np.testing.assert_allclose(v[-1], [0.004 / 0.4 / SCALE, 0.0, 0.0], rtol=1e-6, atol=1e-12)


def test_speed_along_a_wide_passage_is_limited():
    v = led(calm(pace=0.1), aim(width=0.02), updates=300)
    assert v[-1][0] * SCALE == pytest.approx(0.03, rel=1e-6)


def test_an_operator_looks_ahead_as_far_as_the_tool_moves_within_the_delays():
    """10 mm/s within 0.16 s of sight and 0.08 s of the muscles."""
    operator = Operator(calm(pace=0.4, visual_delay=0.16), Senses(), 1)
    assert operator.preview == 0.0
    operator.lead(np.zeros(3), 0.0, np.zeros(3), aim(), SCALE)
    assert operator.preview == pytest.approx(0.01 * (0.16 + 0.08))


def test_the_hand_slows_down_before_the_end_of_the_path():
    """The rest of the path would take 0.3 s at any time."""
    v = led(calm(pace=0.4), replace(aim(), ahead=0.0015), updates=300)
    assert v[-1][0] * SCALE == pytest.approx(0.0015 / 0.3, rel=1e-6)


def test_a_row_of_a_trial_is_every_fourth_cycle():
    trial = done(calm(), line(), sim=Glass((0.0, 0.0, -0.001), wind=(0.3, 0.0, -0.4)), most=0.5)
    assert not trial.done
    assert trial.t[0] == pytest.approx(0.020), "the first update follows 20 cycles at rest"
    np.testing.assert_allclose(np.diff(trial.t), 0.004, atol=1e-12)
    assert trial.t[-1] == pytest.approx(0.52 + 0.016, abs=0.021), "the time given, and the update that notices it"
    np.testing.assert_allclose(trial.F_hand, 0.5)
    np.testing.assert_allclose(trial.F_T, 400.0 * np.maximum(-trial.p_WT[:, 2], 0.0), atol=1e-12)
    assert trial.q.shape == (len(trial.t), 7)


def test_a_trial_ends_one_millimetre_before_the_end_of_the_path():
    """Seen `visual_delay` late: at 2 mm/s the tool has moved another .3 mm, and at most one update more."""
    trial = done(calm(pace=2.0, visual_delay=0.16), line(0.006))
    assert trial.done
    assert trial.p_WT[-1, 0] == pytest.approx(0.005 + 0.00032, abs=0.0001)


def test_an_operator_has_noise_for_trials_of_30_seconds():
    v = led(calm(noise=0.1, unrest=1e-3), aim(), updates=round(30.0 / STEP))
    assert np.ptp(v[-100:], axis=0).min() > 0.0


def sensed(person, senses, forces, seed=1):
    """What the operator senses of these forces of the tool, after each of them."""
    operator, out = Operator(person, senses, seed), []
    for F in forces:
        operator.lead(np.zeros(3), F, np.zeros(3), aim(press=0.5), SCALE)
        out.append(operator.F)
    return np.array(out)


@pytest.mark.parametrize(("force", "delay"), [("felt", 0.1), ("looks", 0.16), ("shown", 0.16)])
def test_a_force_is_sensed_after_its_delay(force, delay):
    person = calm(touch_delay=0.1, visual_delay=0.16, threshold=0.04)
    n = round(delay / STEP)
    F = sensed(person, Senses(force), [0.0] * 5 + [0.8] * 20)
    assert not F[: 5 + n].any()
    assert F[5 + n] > 0.5
    F = sensed(person, Senses(force), [0.7, 1.4, 2.1])
    np.testing.assert_allclose(F, 0.7, rtol=0.35, err_msg="before the delay has passed, the first force counts")


def test_a_felt_force_below_the_threshold_is_not_sensed():
    person = calm(threshold=0.04)
    assert not sensed(person, Senses("felt"), [0.04] * 20).any()
    np.testing.assert_allclose(sensed(person, Senses("felt"), [0.05] * 20)[10:], 0.05)
    assert sensed(person, Senses("looks"), [0.03] * 20)[-1] == pytest.approx(0.03)


@pytest.mark.parametrize(("force", "rms"), [("felt", 0.08), ("shown", 0.10)])
def test_error_of_a_sensed_force_is_proportional_to_it(force, rms):
    person = calm(weber=0.08)
    for F in (0.5, 2.0):
        errors = [sensed(person, Senses(force), [F] * 400, seed)[20:] / F - 1.0 for seed in range(30)]
        assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(rms, rel=0.15)
        assert abs(np.mean(errors)) < 0.25 * rms


def test_without_felt_force_people_press_harder():
    person = calm(haste=1.4)
    start = Glass((0, 0, 0.0005))
    assert done(person, line(0.05, press=0.5), Senses("looks"), start, most=6.0).F_T[-50:].mean() == pytest.approx(
        0.7, rel=0.03
    )
    start = Glass((0, 0, 0.0005))
    assert done(person, line(0.05, press=0.5), Senses("felt"), start, most=6.0).F_T[-50:].mean() == pytest.approx(
        0.5, rel=0.03
    )


def test_speed_of_pressing_is_limited_both_ways():
    person = calm(visual_gain=0.0)
    for goal, sign in ((aim(press=9.0, stiffness=100.0), -1.0), (aim(press=1e-6, stiffness=1.0), 1.0)):
        operator = Operator(person, Senses("felt"), 1)
        v = [operator.lead(np.zeros(3), 5.0 * (sign > 0.0), np.zeros(3), goal, SCALE) for _ in range(200)][-1]
        assert v[2] * SCALE == pytest.approx(sign * 0.03, rel=1e-6)


def test_the_goal_is_the_nearest_point_within_reach_of_the_last_one():
    """Of a path that returns 1 mm beside itself, the piece that follows the last nearest point counts."""
    way = np.linspace(0.0, 0.03, 31)
    path = np.concatenate([
        np.column_stack([way, 0 * way, 0 * way]), np.column_stack([way[::-1], 0 * way + 0.001, 0 * way])
    ])  # fmt: skip
    errand = Errand(path, np.linspace(0.004, 0.008, len(path)), 400.0)
    goal, at = errand.aim(np.array([0.0101, 0.0009, 0.0]), 8)
    assert at == 10
    np.testing.assert_allclose(goal.along, [1.0, 0.0, 0.0])
    np.testing.assert_allclose(goal.error, [0.0, -0.0009, 0.0], atol=1e-12)
    assert goal.width == pytest.approx(errand.width[10])
    assert goal.ahead == pytest.approx(0.030 - 0.010 + 0.001 + 0.030)
    goal, at = errand.aim(np.array([0.0101, 0.0009, 0.0]), 48)
    assert at == 51
    np.testing.assert_allclose(goal.along, [-1.0, 0.0, 0.0])
    goal, at = errand.aim(np.array([-0.05, 0.0, 0.0]), 55, preview=0.01)
    assert at == 61, "the last point, however far the tool is"
    turning, _ = errand.aim(np.array([0.026, 0.0, 0.0]), 24, preview=0.010)
    np.testing.assert_allclose(turning.along, [-1.0, 0.0, 0.0])


def test_the_error_leaves_out_the_direction_of_pressing():
    errand = line(press=0.5)
    goal, at = errand.aim(np.array([0.0101, 0.0007, -0.0030]), 10)
    assert at == 20
    np.testing.assert_allclose(goal.error, [0.0, -0.0007, 0.0], atol=1e-12)
    np.testing.assert_allclose(goal.into, [0.0, 0.0, -1.0])
    touched, _ = line().aim(np.array([0.0101, 0.0007, -0.0030]), 10)
    np.testing.assert_allclose(touched.error, [0.0, -0.0007, 0.0030], atol=1e-12)
