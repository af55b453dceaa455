"""The leader's imperfections in a scene file: options of the simulated arm and of the controller."""

import numpy as np
import pytest

from palpate.base.errors import SceneError
from palpate.report.imperfections import imperfections
from palpate.scene import Scene, rig

ONE = "objects: [{box: {size: [0.1, 0.1, 0.02]}}]\n"


def built(text=""):
    return rig.build(Scene.parse(ONE + text, "s.yaml"))


def test_defaults_are_those_of_the_arm():
    o, arm = built().options().leader, built().arms.leader.leader_options()
    for key in ("encoder_step", "coulomb", "tau_max", "velocity_window", "velocity_cutoff", "drive_lag", "loop_jitter"):
        assert np.array_equal(getattr(o, key), getattr(arm, key)), key


def test_imperfections_affect_the_arm_but_not_the_controller():
    text = "rates: {haptic: 250}\nloop_delay: 0.004\nloop_jitter: 0.002\narms: {leader: {encoder_scale: 4, "
    text += "velocity: difference, velocity_cutoff: 30, drive_lag: 0.001, drive_limit_scale: 0.5, coulomb_scale: 2}}\n"
    o, arm = built(text).options(), built().arms.leader.leader_options()
    assert (o.loop_delay, o.loop_jitter, o.leader.drive_lag) == (0.004, 0.002, 0.001)
    assert (o.leader.velocity_window, o.leader.velocity_cutoff) == (1 / 250, 30)
    assert o.leader.encoder_step == pytest.approx(4 * arm.encoder_step)
    assert o.leader.coulomb == pytest.approx(2 * arm.coulomb)
    assert o.leader.tau_max == pytest.approx(0.5 * arm.tau_max)
    assert o.torque.friction.coulomb == pytest.approx(arm.coulomb)


def test_user_defined_encoder_counts():
    o = built("arms: {leader: {encoder_step: [1e-3, 1e-3, 1e-3, 0, 0, 0, 0]}}").options()
    assert o.leader.encoder_step.tolist() == [1e-3] * 3 + [0] * 4


@pytest.mark.parametrize(
    ("leader", "message"),
    [
        ("encoder_step: [1e-3]", "s.yaml:2: arms.leader.encoder_step must have 7 numbers, one per joint. Got: 1"),
        ("quantised: false, velocity_cutoff: 30", "quantised: false reads the true velocities"),
        ("velocity: fast", "arms.leader.velocity must be 'edges' or 'difference'. Got: 'fast'"),
        ("drive_lag: 2", "arms.leader.drive_lag must be at most 1. Got: 2"),
    ],
)
def test_mistakes_are_reported(leader, message):
    with pytest.raises(SceneError) as caught:
        built(f"arms: {{leader: {{{leader}}}}}")
    assert message in str(caught.value)


@pytest.mark.parametrize("rate", [50, 100, 333, 1000, 4000, 10_000])
def test_every_rate_runs_and_compensates_gravity(rate):
    rows = built(f"rates: {{haptic: {rate}}}").simulation().run(rate // 2)
    assert len(rows) == rate // 2
    assert np.isfinite(rows).all()


def test_jitter_is_reproducible_and_depends_on_the_seed():
    text = "loop_delay: 0.003\nloop_jitter: 0.005\noperator: {palpate: {approach: 0.1, press: 0.1}}\n"
    a, b, c = (built(text).simulation(seed).run(600)[:, :40] for seed in (1, 1, 2))
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


def test_report_lists_the_active_imperfections():
    rows = {what: (words, on) for what, words, on in imperfections(Scene.parse(ONE))}
    assert rows["loop delay"] == ("none", False)
    assert rows["encoders"] == ("counts of 1 times the hardware's", True)
    assert rows["hand"] == ("normal: 0.15 kg, 10 N s/m, 300 N/m to its intended path", True)
    text = "loop_delay: 0.01\noperator: {mass: 0.2}\narms: {leader: {encoder_scale: 0, coulomb_scale: 0}}"
    rows = {what: (words, on) for what, words, on in imperfections(Scene.parse(ONE + text))}
    assert rows["loop delay"] == ("10 ms, of the force's torque", True)
    assert (rows["encoders"][1], rows["dry friction"]) == (False, ("none", False))
    assert rows["hand"][0].startswith("own: 0.2 kg")
