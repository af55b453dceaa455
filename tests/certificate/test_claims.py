"""Claims of the certificate that no other test states: the sure stiffness, advice about delay, trials, poses."""

import numpy as np
import pytest

import palpate
from palpate.certificate import trials
from palpate.certificate.scene import _poses
from palpate.hands import PRESETS
from palpate.scene.rig import build

DEVICE = palpate.DeviceModel(mass=0.3, damping=0.6, rate=1000, delay=0.009, filter=50, quantum=1e-5, friction=0.05)


def test_sure_stiffness_is_97_percent_of_the_lower_limit():
    limits = palpate.certify(DEVICE, B=0.6)
    assert limits.k_sure == pytest.approx(0.97 * min(limits.k_max, limits.k_linear))
    assert palpate.certify(DEVICE, K=0.999 * limits.k_sure, B=0.6).verdict == "stable"
    assert palpate.certify(DEVICE, K=1.001 * limits.k_sure, B=0.6).verdict != "stable"


@pytest.mark.parametrize(("delay", "advice"), [(0.009, "3 ms less delay"), (0.0012, "0.4 ms less delay"), (0.0, "")])
def test_advice_is_a_third_less_delay_in_whole_milliseconds_where_possible(delay, advice):
    reason = palpate.certify(palpate.DeviceModel(mass=0.3, damping=0.6, rate=1000, delay=delay), K=1e5, B=0.6).reason
    assert (advice in reason) if advice else ("less delay" not in reason)


def test_a_device_that_always_oscillates_has_no_stable_stiffness(monkeypatch):
    monkeypatch.setattr(trials, "oscillates", lambda device, hand, K, B: True)
    assert trials.limit(DEVICE, next(iter(PRESETS.values())), 0.0, 500.0) == 0.0


@pytest.mark.parametrize(("expected", "edge"), [(500.0, 200.0), (0.5, 0.2)])
def test_the_limit_of_trials_is_where_they_begin_to_oscillate(monkeypatch, expected, edge):
    monkeypatch.setattr(trials, "oscillates", lambda device, hand, K, B: edge < K)
    assert trials.limit(DEVICE, next(iter(PRESETS.values())), 0.0, expected) == pytest.approx(edge, rel=0.02)


def test_poses_of_a_scene_place_the_tool_on_the_operators_path():
    rig = build(
        palpate.Scene.parse("""
mapping: {scale: 0.5}
objects: [{name: table, plane: {size: 0.3}, stiffness: 800}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0.01, -0.005, 0.01]}, {t: 2, xyz: [0.02, 0.01, -0.001]}]}
""")
    )
    arms = rig.arms
    start = arms.leader.fk(arms.q_leader0)[:3, 3]
    tool = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    found = dict(_poses(rig))
    assert len(found) >= 2
    for words, q in found.items():
        if words == "at the start":
            continue
        t = float(words.split()[1])
        wanted = rig.path.positions_W[np.argmin(np.abs(rig.path.times - t))]
        moved = arms.X_WL[:3, :3] @ (arms.leader.fk(q)[:3, 3] - start)
        np.testing.assert_allclose(tool + 0.5 * moved, wanted, atol=5e-4)
