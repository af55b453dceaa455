"""Functions beyond motion: sound, coupling, tool engagement, excessive current."""

import numpy as np
import pytest


def events_of(news, component, topic):
    return [value for _, who, what, value in news if (who, what) == (component, topic)]


def test_volume_is_clipped_and_published(robot):
    r = robot("PSM1")
    assert events_of(r.run(0.01), "system", "volume") == [0.5]
    for requested, published in ((0.25, 0.25), (3.0, 1.0), (-1.0, 0.0)):
        r.send("system", "set_volume", requested)
        news = r.run(0.01)
        assert events_of(news, "system", "volume") == [published]
        assert f"volume set to {round(100 * published)}%" in events_of(news, "system", "status")[0]
    r.send("system", "set_volume", np.nan)
    assert events_of(r.run(0.01), "system", "volume") == []


@pytest.mark.parametrize(
    ("values", "status", "problem"),
    [
        ([0.5], "beep, 0.5 s, 3000 Hz, volume 0.5", None),
        ([0.01, 440, 2], "beep, 0.1 s, 440 Hz, volume 1", "warning"),
        ([], None, "error"),
        ([1, 2, 3, 4], None, "error"),
        ([np.inf], None, "error"),
    ],
)
def test_beeps_are_checked_as_on_the_real_system(robot, values, status, problem):
    r = robot("PSM1")
    r.run(0.01)
    r.send("system", "beep", values)
    news = r.run(0.01)
    assert events_of(news, "system", "status") == ([f"system: {status}"] if status else [])
    assert bool(r.messages("warning", news) or r.messages("error", news)) == (problem is not None)
    assert bool(problem is None or r.messages(problem, news))


def test_speech_is_published(robot):
    r = robot("PSM1")
    r.send("system", "string_to_speech", "mind the tool")
    assert "system: says: mind the tool" in events_of(r.run(0.01), "system", "status")


def test_actuator_positions_give_joint_positions(robot):
    """A parallelogram keeps the forearm's absolute angle; opposite disk rotations open the jaw without wrist motion."""
    r = robot("MTMR", "PSM1", "ECM")
    m = np.zeros(7)
    m[1] = 0.2
    q = r.system.joint_position("MTMR", m)
    assert q[1] + q[2] == pytest.approx(0.0)
    disks = np.zeros(7)
    disks[5], disks[6] = -0.5, 0.5
    q = r.system.joint_position("PSM1", disks)
    np.testing.assert_allclose(q, [0, 0, 0, 0, 0, 0, 1.2177], atol=1e-12)
    np.testing.assert_array_equal(r.system.joint_position("ECM", [0.1, 0.2, 0.3, 0.4]), [0.1, 0.2, 0.3, 0.4])
    assert r.system.joint_position("PSM1", np.zeros(6)) is None
    assert r.system.joint_position("PSM1", np.full(7, np.nan)) is None


@pytest.mark.parametrize("verb", ["jaw/servo_jp", "jaw/servo_jf"])
def test_jaw_with_a_servo_command_during_a_move_is_no_longer_busy(robot, verb):
    r = robot("PSM1").home()
    r.send("PSM1", "jaw/move_jp", [1.0])
    r.run(0.02)
    assert r.state("PSM1")["is_busy"]
    r.send("PSM1", verb, [0.1])
    r.run(0.02)
    assert not r.state("PSM1")["is_busy"]


def retracted(robot):
    r = robot("PSM1").home()
    q = r.state("PSM1")["measured_js"]["position"].copy()
    q[2] = 0.005
    r.send("PSM1", "move_jp", q)
    r.run(3.0)
    return r


def test_inserted_tool_is_rotated_until_it_engages(robot):
    r = retracted(robot)
    r.send("PSM1", "emulate_tool_present", False)
    r.run(0.1)
    r.send("PSM1", "emulate_tool_present", True)
    reach, news = np.zeros(2), []
    for _ in range(400):
        news += r.run(0.01)
        state = r.state("PSM1")
        roll = state["measured_js"]["position"][3]
        reach = np.array([min(reach[0], roll), max(reach[1], roll)])
        if state["is_homed"]:
            break
        assert state["is_busy"] or len(news) < 5
        r.send("PSM1", "jaw/servo_jp", [0.2])
    np.testing.assert_allclose(reach, [-np.pi / 6, np.pi / 6], atol=0.01)
    assert [w for w in r.messages("status", news) if "engaging tool" in w] == [
        f"PSM1: engaging tool {k} of 3" for k in (1, 2, 3)
    ]
    assert any("jaw_servo_jp, arm not ready" in w for w in r.messages("warning", news))
    assert "PSM1: tool engaged" in r.messages("status", news)
    assert abs(roll) < 0.01
    assert events_of(news, "PSM1", "current_state")[0] == "ENGAGING_TOOL"


def test_tool_inserted_past_the_cannula_does_not_move_the_arm(robot):
    r = robot("PSM1").home()
    before = r.state("PSM1")["measured_js"]["position"]
    for present in (False, True):
        r.send("PSM1", "emulate_tool_present", present)
        news = r.run(0.5)
    assert any("outside the cannula" in w for w in r.messages("status", news))
    np.testing.assert_allclose(r.state("PSM1")["measured_js"]["position"], before, atol=1e-9)
    assert r.state("PSM1")["is_homed"]


@pytest.mark.parametrize("verb", ["servo_jf", "body/servo_cf", "spatial/servo_cf"])
def test_effort_above_the_limit_is_a_fault(robot, verb):
    r = robot("MTMR").home()
    value = [3.0, 0, 0, 0, 0, 0, 0] if verb == "servo_jf" else [0.0, 0, 40.0, 0, 0, 0]
    r.send("MTMR", verb, value)
    r.run(0.05)
    assert r.state("MTMR")["state"] == "ENABLED"
    news = r.run(0.15)
    assert r.state("MTMR")["state"] == "FAULT"
    [error] = r.messages("error", news)
    assert "requested effort is too large on joint" in error
    assert "limit" in error
    r.run(0.01)
    assert np.all(r.system.truth("MTMR")["effort"] == 0.0)


def test_effort_below_the_limit_or_briefly_above_it_is_no_fault(robot):
    r = robot("MTMR").home()
    for value in ([1.8, 0, 0, 0, 0, 0, 0], [3.0, 0, 0, 0, 0, 0, 0], [0.0] * 7):
        r.send("MTMR", "servo_jf", value)
        r.run(0.09)
    assert r.state("MTMR")["state"] == "ENABLED"
