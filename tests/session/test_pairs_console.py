"""One console and one camera for all pairs: pedals, requests, steering with both hands, swap, and continuity."""
# ruff: noqa: RUF005  (the sums are of arrays)

from pathlib import Path

import numpy as np
import pytest

from palpate import _core
from palpate.arm.ecm import R_CD
from palpate.base.errors import StateError
from palpate.scene import Scene
from palpate.scene.overrides import override
from palpate.session import PairsSession, machine

DT = 1e-3
V_MAX = 0.3
"""Fastest motion of a tool goal in these scenes [m/s]."""
QUICK = {
    f"pairs.{name}.operator.palpate.{key}": value
    for name in ("right", "left")
    for key, value in (("approach", 0.3), ("press", 0.2))
}


@pytest.fixture(scope="module")
def scene():
    found = Scene.load(Path(__file__).resolve().parents[2] / "scenes" / "two_hands.yaml")
    return override(found, {"ecm": {}, "objects.0.triangles": 3000, "mapping.align_rate": 0, **QUICK})


def pressed(scene):
    """A session both of whose tools have been in the organ for a while."""
    session = PairsSession(scene)
    session.step(700)
    assert {state.session for state in session.states.values()} == {"following"}
    assert all(state.force > 0.3 for state in session.states.values())
    return session


def steps_of(session, ticks):
    """Ticks of each pair in the next steps, the last ones before them included."""
    rows = {name: [state.tick] for name, state in session.states.items()}
    for _ in range(ticks):
        for name, state in session.step().items():
            rows[name].append(state.tick)
    return {name: np.array(one) for name, one in rows.items()}


def jumps(ticks):
    """Largest change of force over its cap, and of the tool goal and the tool over the fastest motion, in a tick."""
    most = {"F_H_L": _core.StabilityOptions().rate_cap * DT, "p_WT_goal": V_MAX * DT, "p_WT": V_MAX * DT}
    return {name: float(np.linalg.norm(np.diff(ticks[name], axis=0), axis=1).max() / cap) for name, cap in most.items()}


def states_in(ticks):
    """Names of the states in ticks, in the order in which they appear."""
    return list(dict.fromkeys(machine.name_of(x) for x in ticks["session_state"]))


def test_the_pairs_have_one_console_and_one_camera(scene):
    session = PairsSession(scene)
    assert all(one.console is session.console and one.camera is None for one in session.pairs.values())
    placed = [rig.ecm for rig in session.rigs.values()]
    np.testing.assert_array_equal(placed[0].X_WB, placed[1].X_WB)
    starts = np.array([rig.path.positions_W[0] for rig in session.rigs.values()])
    seen = np.linalg.inv(session.camera.X_WC) @ np.append(starts.mean(axis=0), 1.0)
    np.testing.assert_allclose(seen[:3], [0, 0, 0.09], atol=1e-9)


@pytest.mark.parametrize("pedal", ["clutch", "camera"])
def test_a_pedal_acts_on_all_hands_without_a_step_of_force_or_pose(scene, pedal):
    session = pressed(scene)
    q = session.camera.q
    session.console.press(pedal)
    held = steps_of(session, 250)
    moved = session.camera.q - q
    session.console.release(pedal)
    after = steps_of(session, 250)
    assert np.any(moved != 0.0) == (pedal == "camera"), "the hands go on along their paths"
    for name in session.pairs:
        assert states_in(held[name])[1:] == ["clutched" if pedal == "clutch" else "camera"]
        assert states_in(after[name])[1:] == ["following"]
        assert not np.any(np.diff(held[name]["p_WT_goal"][1:], axis=0)), "the tools hold"
        assert np.linalg.norm(held[name]["F_H_L"][-1]) == 0.0
        for ticks in (held[name], after[name]):
            assert max(jumps(ticks).values()) <= 1.0 + 1e-9, (name, jumps(ticks))


def test_a_step_of_force_or_pose_would_be_noticed(scene):
    ticks = steps_of(pressed(scene), 20)["left"]
    assert max(jumps(ticks).values()) <= 1.0
    for signal, jump in (("F_H_L", 0.5), ("p_WT_goal", 1e-3), ("p_WT", 1e-3)):
        wrong = ticks.copy()
        wrong[signal][10:] += [jump, 0, 0]
        assert jumps(wrong)[signal] > 1.0


def moved_camera(session, by_D, turn=0.0):
    """The camera before and after both handles moved by (3,) in the display, and turned about their middle [rad]."""
    camera, rigs = session.camera, list(session.rigs.values())
    R_WD = camera.X_WC[:3, :3] @ R_CD
    X_WL = [rig.arms.X_WL for rig in rigs]
    p_W = np.array(
        [X[:3, :3] @ one.latest()["p_LH"] + X[:3, 3] for X, one in zip(X_WL, session.pairs.values(), strict=True)]
    )
    middle, before = p_W.mean(axis=0), camera.X_WC
    for s in np.linspace(0.0, 1.0, 101):
        c, d = np.cos(s * turn), np.sin(s * turn)
        R_W = R_WD @ np.array([[c, -d, 0], [d, c, 0], [0, 0, 1.0]]) @ R_WD.T
        now = middle + (p_W - middle) @ R_W.T + s * R_WD @ np.asarray(by_D)
        camera.step(True, [X[:3, :3].T @ (p - X[:3, 3]) for X, p in zip(X_WL, now, strict=True)], 0.02)
    return before, camera.X_WC


def angle_in_picture(X_WC, by_W):
    """Angle, counter-clockwise in the picture, of a direction (3,) in W [rad]."""
    p = X_WC[:3, :3].T @ by_W
    return np.arctan2(-p[1], p[0])


def test_both_hands_steer_the_camera_though_the_bases_of_their_leaders_differ(scene):
    """They hold the picture: it rolls with the line between them, pans with them, and comes nearer with them."""
    session = PairsSession(scene)
    session.step()
    insertion = session.camera.q[2]
    moved_camera(session, [0, 0, 0.02])
    assert session.camera.q[2] == pytest.approx(insertion + 0.02, abs=1e-9)
    first, last = moved_camera(PairsSession(scene), [0, 0, 0], turn=0.3)
    right = first[:3, 0]
    assert angle_in_picture(last, right) - angle_in_picture(first, right) == pytest.approx(0.3, abs=1e-3)
    session = PairsSession(scene)
    session.step()
    first, last = moved_camera(session, [0.04, 0, 0])
    forward = last[:3, :3].T @ first[:3, 2]
    assert forward[0] / forward[2] == pytest.approx(0.04 / 0.4, rel=0.02), "what was ahead is now on the right"
    assert abs(forward[1]) < 1e-3


def test_a_hand_in_a_fault_does_not_steer(scene):
    session = pressed(scene)
    session.pairs["left"].request("power_off")
    session.console.press("camera")
    session.step(2)
    assert [state.session for state in session.states.values()] == ["camera", "off"]
    camera, p = session.camera, np.array([state.tick["p_LH"] for state in session.states.values()])
    camera.step([True, False], p, 0.01)
    rest = camera.q
    camera.step([True, False], p + [[0, 0, 0], [0.05, 0.05, 0]], 0.01)
    np.testing.assert_array_equal(camera.q, rest)
    camera.step([True, False], p + [[0.05, 0.05, 0], [0, 0, 0]], 0.01)
    assert np.any(camera.q != rest)
    rest = camera.q
    camera.step([True, True], p, 0.01)  # another hand has come: no leap
    np.testing.assert_array_equal(camera.q, rest)


def test_hands_of_all_pairs_follow_the_picture_after_it_has_rolled(scene):
    session = PairsSession(scene)
    session.step(100)
    before = session.camera.X_WC[:3, :3]
    session.camera.move_to(session.camera.q + [0.1, -0.1, 0.01, 0.5])
    after = session.camera.X_WC[:3, :3]
    ticks = steps_of(session, 150)
    for name, rig in session.rigs.items():
        R_CL = before.T @ rig.arms.X_WL[:3, :3]  # the hand in the picture, as at the start
        hand = ticks[name]["p_LH"][-1] - ticks[name]["p_LH"][1]
        tool = ticks[name]["p_WT_goal"][-1] - ticks[name]["p_WT_goal"][1]
        assert np.linalg.norm(hand) > 1e-3
        np.testing.assert_allclose(after.T @ tool, 0.5 * R_CL @ hand, atol=1e-9)
        assert max(jumps(ticks[name]).values()) <= 1.0


def test_locks_scale_hold_and_presence_act_on_all_pairs(scene):
    session = PairsSession(scene)
    session.step(20)
    session.console.lock_rotation()
    session.console.set_scale(0.2)
    assert all(one.controls.lock_rotation and one.controls.scale == 0.2 for one in session.pairs.values())
    session.console.begin_tool_exchange()
    assert {state.session for state in session.step(2).values()} == {"hold"}
    with pytest.raises(StateError, match="the session is hold"):
        session.request("clutch")
    assert not any(one.controls.clutch for one in session.pairs.values())
    session.console.end_tool_exchange()
    assert {state.session for state in session.step(2).values()} == {"following"}
    session.console.release("head", "sensor")
    assert {state.session for state in session.step(2).values()} == {"homed"}


def test_a_hold_waits_for_a_pair_that_cannot_take_it_yet(scene):
    session = PairsSession(scene)
    session.step(20)
    session.pairs["left"].request("power_off")
    session.step()
    session.request("hold")
    assert [state.session for state in session.step().values()] == ["hold", "off"]
    session.pairs["left"].request("power_on")
    assert [state.session for state in session.step().values()] == ["hold", "hold"], "no tool moves meanwhile"
    session.request("resume")
    assert {state.session for state in session.step().values()} == {"following"}
    with pytest.raises(StateError, match="no request 'holt'"):
        session.request("holt")


def test_swap_exchanges_the_followers_of_both_hands(scene):
    session = PairsSession(scene)
    session.step(20)
    session.console.lock_rotation()
    before = {name: (rig.arms.leader.name, rig.arms.X_WL, rig.arms.X_WB) for name, rig in session.rigs.items()}
    session.console.swap()
    for name, other in (("left", "right"), ("right", "left")):
        arms = session.rigs[name].arms
        assert arms.leader.name == before[other][0]
        np.testing.assert_array_equal(arms.X_WL, before[other][1])
        np.testing.assert_array_equal(arms.X_WB, before[name][2])
    assert all(one.controls.lock_rotation and one.console is session.console for one in session.pairs.values())
    assert {state.session for state in session.step(20).values()} == {"following"}
    session.console.swap()
    assert session.rigs["left"].arms.leader.name == before["left"][0]


def test_a_swap_that_does_not_fit_is_refused_and_changes_nothing(scene):
    session = PairsSession(scene)
    session.start()
    with pytest.raises(StateError, match="while the session runs"):
        session.console.swap()
    assert session.running
    session.stop()
    rigs = session.rigs
    short = override(scene, {"pairs.left.arms.leader.start": [0.0, 0.0, 0.0]})
    session.scene = short  # its left leader fits no follower
    with pytest.raises(StateError, match=r"do not fit each other's followers: .*start must have"):
        session.console.swap()
    assert session.rigs is rigs
    session.scene = scene
    session.remove("left")
    with pytest.raises(StateError, match="one hand"):
        session.console.swap()


def test_a_pair_that_loses_power_returns_without_a_step_while_the_other_is_unaffected(scene):
    session, undisturbed = pressed(scene), pressed(scene)
    session.pairs["left"].request("power_off")
    off = steps_of(session, 60)
    session.pairs["left"].request("power_on")
    on = steps_of(session, 200)
    reference = steps_of(undisturbed, 260)["right"]
    assert states_in(off["left"]) == ["following", "off"]
    assert states_in(on["left"]) == ["off", "following"]
    for ticks in (off["left"], on["left"]):
        assert max(jumps(ticks).values()) <= 1.0 + 1e-9
    for signal in ("q", "tau", "F_H_L", "p_WT_goal", "session_state"):
        ours = np.concatenate([off["right"][signal], on["right"][signal][1:]])
        np.testing.assert_array_equal(ours, reference[signal])
