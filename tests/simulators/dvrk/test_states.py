"""The operating state: every command in every state, and the behaviour of an arm in each state."""

import numpy as np
import pytest

COMMANDS = ("enable", "disable", "home", "unhome", "pause", "resume")
#: State two seconds after a command; None: refused. As the table of the real component; DISABLED accepts what ENABLED
#: accepts. `home` gets four seconds.
TABLE = {
    "DISABLED": ("ENABLED", "DISABLED", "ENABLED", "DISABLED", "PAUSED", None),
    "ENABLED": ("ENABLED", "DISABLED", "ENABLED", "ENABLED", "PAUSED", None),
    "HOMED": ("ENABLED", "DISABLED", "ENABLED", "ENABLED", "PAUSED", None),
    "PAUSED": (None, "DISABLED", None, "PAUSED", "PAUSED", "ENABLED"),
    "FAULT": (None, "DISABLED", None, "FAULT", None, None),
}


def bring(robot, name, arm="PSM1"):
    r = robot(arm)
    if name == "ENABLED":
        r.send(arm, "state_command", "enable")
        r.run(1.0)
    if name in ("HOMED", "PAUSED", "FAULT"):
        r.home()
    if name == "PAUSED":
        r.send(arm, "state_command", "pause")
    if name == "FAULT":
        r.send(arm, "emulate_fault", "emulated power failure")
    r.run(0.1)
    r.events.clear()
    return r


@pytest.mark.parametrize("state", TABLE)
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_in_every_state_has_the_documented_result(robot, state, command):
    r = bring(robot, state)
    r.send("PSM1", "state_command", command)
    r.run(3.0)
    expected = TABLE[state][COMMANDS.index(command)]
    now = r.state("PSM1")
    if expected is None:
        [warning] = r.messages("warning")
        assert warning.startswith(f'PSM1: command "{command}" is not supported in state "')
        assert now["state"] == {"HOMED": "ENABLED"}.get(state, state)
        return
    assert now["state"] == expected
    assert not r.messages("warning")
    if command == "home":
        assert now["is_homed"]
    if command in ("disable", "unhome"):
        assert not now["is_homed"]


def test_unknown_command_is_reported(robot):
    r = robot("PSM1")
    r.send("PSM1", "state_command", "Home")
    r.run(0.01)
    [warning] = r.messages("warning")
    assert "Home doesn't seem to be a valid state_command" in warning


def test_homing_is_busy_and_ends_at_the_home_pose(robot):
    r = robot("MTMR", "PSM1", "ECM")
    for arm in ("MTMR", "PSM1", "ECM"):
        r.send(arm, "state_command", "home")
    r.run(1.0)
    assert r.state("MTMR")["is_busy"]
    r.home()
    assert np.abs(r.state("MTMR")["measured_js"]["position"]).max() < 0.05  # friction keeps the platform slightly off
    assert np.allclose(r.state("PSM1")["measured_js"]["position"], [0, 0, 0.12, 0, 0, 0], atol=1e-4)
    assert np.allclose(r.state("ECM")["measured_js"]["position"], [0, 0, 0.1, 0], atol=1e-4)
    states = [e[3] for e in r.events if e[1:3] == ("MTMR", "operating_state")]
    assert states[-1] == ("ENABLED", True, False)
    assert [e[3] for e in r.events if e[1:3] == ("MTMR", "current_state")][-1] == "HOMED"


def test_states_are_invalid_until_homed_and_commands_before_are_refused(robot):
    r = robot("MTMR")
    assert not r.state("MTMR")["joints_valid"]
    for verb, value in (("servo_jp", np.zeros(7)), ("body/servo_cf", np.zeros(6)), ("move_cp", np.eye(4))):
        r.send("MTMR", verb, value)
        r.run(2.5)  # refusals are reported every two seconds
    assert r.messages("warning") == [
        "MTMR: servo_jp, arm not ready",
        "MTMR: body_servo_cf, arm not ready",
        "MTMR: move_cp, arm not ready (2 errors)",
    ]


def test_refusals_are_reported_at_a_limited_rate(robot):
    r = robot("MTMR")
    for _ in range(300):
        r.send("MTMR", "body/servo_cf", np.zeros(6))
        r.run(0.01)
    assert len(r.messages("warning")) == 2


def test_disabled_master_arm_falls_and_a_paused_one_keeps_its_last_command(robot):
    r = robot("MTMR").home()
    r.send("MTMR", "servo_jp", np.zeros(7))
    r.run(0.5)
    r.send("MTMR", "state_command", "pause")
    r.run(1.0)
    assert np.abs(r.system.truth("MTMR")["position"][:3]).max() < 0.02
    r.send("MTMR", "state_command", "disable")
    r.run(2.0)
    assert np.all(r.system.truth("MTMR")["effort"] == 0)
    assert np.abs(r.system.truth("MTMR")["position"][:3]).max() > 0.2


def test_resume_continues_after_a_pause(robot):
    r = robot("PSM1").home()
    r.send("PSM1", "servo_jp", [0.3, 0, 0.12, 0, 0, 0])
    r.run(0.5)
    r.send("PSM1", "state_command", "pause")
    r.run(0.1)
    r.send("PSM1", "servo_jp", [0.0, 0, 0.12, 0, 0, 0])
    r.run(0.5)
    assert abs(r.state("PSM1")["measured_js"]["position"][0] - 0.3) < 1e-3
    r.send("PSM1", "state_command", "resume")
    r.run(0.1)
    assert r.state("PSM1")["state"] == "ENABLED"
    r.send("PSM1", "servo_jp", [0.1, 0, 0.12, 0, 0, 0])
    r.run(0.5)
    assert abs(r.state("PSM1")["measured_js"]["position"][0] - 0.1) < 1e-3


def test_tracking_error_is_a_fault_that_only_disable_ends(robot):
    """servo_jp does not interpolate, so a jump exceeds the tracking tolerance."""
    r = robot("PSM1").home()
    r.send("PSM1", "servo_jp", [1.0, 0, 0.12, 0, 0, 0])
    r.run(0.1)
    assert r.state("PSM1")["state"] == "FAULT"
    assert any("position error is too large on joint yaw" in w for w in r.messages("error"))
    r.send("PSM1", "state_command", "disable")
    r.run(0.1)
    r.home()
    assert r.state("PSM1")["is_homed"]


def test_system_powers_all_arms(robot):
    r = robot("MTMR", "PSM1")
    r.send("system", "power_on")
    r.run(1.0)
    assert [r.state(a)["state"] for a in ("MTMR", "PSM1")] == ["ENABLED", "ENABLED"]
    r.send("system", "home")
    r.run(6.0)
    assert all(r.state(a)["is_homed"] for a in ("MTMR", "PSM1"))
    r.send("system", "power_off")
    r.run(0.1)
    assert [r.state(a)["state"] for a in ("MTMR", "PSM1")] == ["DISABLED", "DISABLED"]
