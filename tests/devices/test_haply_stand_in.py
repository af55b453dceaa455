"""The stand-in of Haply's service against the messages that the vendor documents, with a client of `websockets`."""

import json
import socket
import time
import urllib.error
import urllib.request

import numpy as np
import pytest

pytest.importorskip("websockets", reason="the stand-in needs the extra haply")

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from palpate.base.errors import DeviceError
from palpate.devices.haply.messages import DIALECTS, Grip
from palpate.devices.haply.stand_in import FAULTS, MIDDLE, Fault, Options, StandIn

XYZ = {"x": float, "y": float, "z": float}
XYZW = {**XYZ, "w": float}
CONFIG = {
    "type": str, "device_info": {"id": str, "uuid": str}, "handedness": str,
    "gravity_compensation": {"enabled": bool, "scaling_factor": float},
    "torque_scaling": {"enabled": bool}, "coordinate_origin": str,
}  # fmt: skip
STATE = {"cursor_position": XYZ, "cursor_velocity": XYZ, "angular_position": {"a0": float, "a1": float, "a2": float},
         "body_orientation": XYZW, "mode": str, "control_domain": str, "control_mode": str}  # fmt: skip
STATUS = {"calibrated": bool, "in_use": bool, "power_supply": bool, "ready": bool, "started": bool}
GRIP_STATE = {"orientation": XYZW, "buttons": {"a": bool, "b": bool, "c": bool}, "hall": int, "battery_level": float}
"""Shapes of the documentation of 3.1 to 3.5: names of keys and kinds of values. Messages may hold more."""


def has_shape(found, shape, where=""):
    for key, kind in shape.items():
        assert key in found, f"{where}.{key} is missing"
        if isinstance(kind, dict):
            has_shape(found[key], kind, f"{where}.{key}")
        else:
            assert isinstance(found[key], kind), f"{where}.{key} is {found[key]!r}"


@pytest.fixture
def service(request):
    with StandIn(0, options=Options(**getattr(request, "param", {}))) as made:
        yield made


def client(service, port="port"):
    return connect(f"ws://127.0.0.1:{getattr(service, port)}", compression=None)


def told(wire, timeout=5.0):
    return json.loads(wire.recv(timeout))


def command(force, key="vector", device="04C3", **more):
    value = dict(zip("xyz", map(float, force), strict=True))
    return json.dumps({"inverse3": [{"device_id": device, "commands": {"set_cursor_force": {key: value, **more}}}]})


def ask(service, path, method="GET", body=None):
    data = None if body is None else json.dumps(body).encode()
    made = urllib.request.Request(f"http://127.0.0.1:{service.port}/{path}", data, method=method)
    with urllib.request.urlopen(made, timeout=5) as answer:
        return json.loads(answer.read())


PROBE = json.dumps({"inverse3": [{"device_id": "04C3", "commands": {"probe_position": {}}}]})


@pytest.mark.parametrize("service", [{"dialect": d} for d in DIALECTS], ids=DIALECTS, indirect=True)
def test_inventory_comes_at_once_and_has_the_documented_shape(service):
    dialect = service.options.dialect
    with client(service) as wire:
        message = told(wire)
    assert isinstance(message["session_id"], int)
    lists = [message[kind] for kind in ("inverse3", "verse_grip", "wireless_verse_grip", "custom_verse_grip")]
    if dialect == "3.0":  # an object with the ids as keys
        assert [list(found) for found in lists] == [["04C3"], [], ["1102"], []]
        device, grip = lists[0]["04C3"], lists[2]["1102"]
    else:
        assert [[one["device_id"] for one in found] for found in lists] == [["04C3"], [], ["1102"], []]
        device, grip = lists[0][0], lists[2][0]
    has_shape(device, {"config": CONFIG, "state": STATE, "status": STATUS})
    has_shape(grip, {"state": GRIP_STATE, "status": {"ready": bool, "connected": bool, "awake": bool}})
    old = dialect in ("3.0", "3.1")
    assert device["config"]["coordinate_system" if old else "basis"] == {"permutation": "XYZ"}
    assert ("model" in device["config"]["device_info"]) == old
    assert ("filters" in device["config"]) == (dialect == "3.5")
    assert device["status"]["calibrated"] is True


def test_each_message_has_exactly_one_answer_and_nothing_is_pushed(service):
    with client(service) as wire:
        told(wire)
        texts = [PROBE, "{}", command([0, 0, 1]), "no JSON", "[1]", '{"inverse3": 3, "unknown": {}}', PROBE]
        for text in texts:
            wire.send(text)
        answers = [told(wire) for _ in texts]
        with pytest.raises(TimeoutError):
            wire.recv(0.1)
    assert all("config" not in a["inverse3"][0] for a in answers), "the configuration comes once, or when asked for"
    assert service.exchanges == len(texts)


def test_full_state_comes_when_asked_for_and_one_message_in_parts_is_one_message(service):
    with client(service) as wire:
        told(wire)
        wire.send(['{"session": {"force_render_', 'full_state": {}}}'])
        assert "config" in told(wire)["inverse3"][0]


@pytest.mark.parametrize(
    ("dialect", "key", "acts", "deprecated"),
    [("3.0", "values", True, False), ("3.1", "values", True, False), ("3.4", "values", True, False),
     ("3.1", "vector", False, False), ("3.4", "vector", False, False), ("3.5", "vector", True, False),
     ("3.5", "values", True, True)],
)  # fmt: skip
def test_the_form_of_a_force_depends_on_the_version(dialect, key, acts, deprecated):
    options = Options(dialect=dialect)
    with StandIn(0, options=options) as made, client(made) as wire, client(made, "events_port") as events:
        told(wire)
        for _ in range(2):
            wire.send(command([1, 2, 3], key))
            told(wire)
        assert made.log[-1][1].tolist() == ([1, 2, 3] if acts else [0, 0, 0])
        if deprecated:
            event = told(events)
            assert (event["name"], event["category"], event["level"]) == ("command-deprecated", "input", "notice")
            assert event["data"] == {"command": "set_cursor_force"}
        with pytest.raises(TimeoutError):  # once in a session
            events.recv(0.1)


@pytest.mark.parametrize(
    "value", [{"x": 1, "y": 2}, {"x": "1", "y": 0, "z": 0}, [1, 2, 3], {"x": True, "y": 0, "z": 0}]
)
def test_an_invalid_force_is_told_as_an_event_and_has_no_effect(service, value):
    with client(service) as wire, client(service, "events_port") as events:
        told(wire)
        body = {"inverse3": [{"device_id": "04C3", "commands": {"set_cursor_force": {"vector": value}}}]}
        wire.send(json.dumps(body))
        told(wire)
        event = told(events)
        assert event["name"] == "invalid-value"
        assert set(event["data"]) == {"field", "reason", "context"}
        assert not service.force().any()


def test_commands_of_other_devices_and_with_execute_false_have_no_effect(service):
    with client(service) as wire:
        told(wire)
        for text in (command([5, 0, 0], device="FFFF"), command([5, 0, 0], execute=False)):
            wire.send(text)
            told(wire)
            assert not service.log[-1][1].any()


def test_the_motors_are_idle_after_the_silence_of_the_client():
    with StandIn(0, options=Options(idle_after=0.05)) as service, client(service) as wire:
        told(wire)
        wire.send(command([0, 0, 2]))
        state = told(wire)["inverse3"][0]["state"]
        assert state["current_cursor_force"]["z"] == 2.0
        assert (state["control_domain"], state["control_mode"]) == ("cartesian", "force")
        at = service.log[-1][0]
        assert service.force(at + 0.049).tolist() == [0, 0, 2]
        assert service.force(at + 0.051).tolist() == [0, 0, 0]
        time.sleep(0.08)
        wire.send(PROBE)
        assert told(wire)["inverse3"][0]["state"]["mode"] == "idle"


def test_a_free_device_moves_by_the_commanded_force_alone():
    """m v' = F - b v, with the friction of the simulated device: within 3 % of its closed form after 0.2 s."""
    with StandIn(0, options=Options(held=False, idle_after=10.0)) as service, client(service) as wire:
        told(wire)
        wire.send(command([0, 1, 0]))
        first = told(wire)
        begin = service.log[-1][0]
        time.sleep(0.2)
        wire.send(PROBE)
        state = told(wire)["inverse3"][0]["state"]
        t = service.log[-1][0] - begin
    m, b, F = 0.2, 0.5, 1.0 - 0.05
    v = F / b * (1.0 - np.exp(-b / m * t))
    y = F / b * (t - m / b * (1.0 - np.exp(-b / m * t)))
    assert first["inverse3"][0]["state"]["cursor_position"]["y"] == pytest.approx(MIDDLE[1], abs=1e-4)
    assert state["cursor_velocity"]["y"] == pytest.approx(v, rel=0.03)
    assert state["cursor_position"]["y"] - MIDDLE[1] == pytest.approx(y, rel=0.03)


@pytest.mark.parametrize("prefix", ["", "3.1/", "3.5/"])
def test_http_has_version_and_devices(service, prefix):
    version = ask(service, f"{prefix}version")
    assert version["project_name"] == "haply-inverse-service"
    assert version["project_version"].startswith("3.5.")
    assert {"build_time", "git_branch", "git_describe", "git_hash", "git_tag"} <= set(version)
    has_shape(ask(service, f"{prefix}devices")["inverse3"][0], {"config": CONFIG, "state": STATE, "status": STATUS})


@pytest.mark.parametrize(
    ("setting", "value"),
    [("gravity_compensation", {"enabled": False, "scaling_factor": 0.5}), ("handedness", "left"),
     ("basis", {"permutation": "ZXY"}), ("preset", {"preset": "arm_front"}), ("filters/damping", {"scalar": 0.25}),
     ("filters/force_gate", {"gain": 0.0})],
)  # fmt: skip
def test_settings_are_set_and_read_back_and_appear_in_the_inventory(service, setting, value):
    path = f"inverse3/04C3/config/{setting}"
    assert ask(service, path, "POST", value) == {"ok": True, "data": value}
    assert ask(service, path) == {"ok": True, "data": value}
    with client(service) as wire:
        config = told(wire)["inverse3"][0]["config"]
    at = config["filters"][setting.split("/")[1]] if "/" in setting else config[setting]
    assert at == (value["preset"] if setting == "preset" else value)


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [("inverse3/04C3/config/handedness", "both", 400), ("inverse3/04C3/config/handedness", 3, 400),
     ("inverse3/04C3/config/colour", "red", 404), ("inverse3/FFFF/config/handedness", "left", 404)],
)  # fmt: skip
def test_settings_that_do_not_exist_are_refused(service, path, body, status):
    with pytest.raises(urllib.error.HTTPError) as error:
        ask(service, path, "POST", body)
    assert error.value.code == status
    assert json.loads(error.value.read())["ok"] is False


def test_settings_of_filters_come_in_a_message_of_3_5(service):
    with client(service) as wire:
        told(wire)
        configure = {"damping": {"scalar": 0.5}, "force_gate": {"gain": 0.1}, "unknown": 1}
        wire.send(json.dumps({"session": {"force_render_full_state": {}},
                              "inverse3": [{"device_id": "04C3", "configure": configure}]}))  # fmt: skip
        filters = told(wire)["inverse3"][0]["config"]["filters"]
    assert filters == {"force_gate": {"gain": 0.1}, "damping": {"scalar": 0.5}}


def test_events_are_read_only(service):
    with client(service, "events_port") as events:
        events.send("hello")
        event = told(events)
    assert event["name"] == "invalid-io-channel"
    has_shape(event, {"name": str, "category": str, "level": str, "data": {"received_data": str}, "message": str})


EVENTS = [
    ("sleep", "device-sleep", "info", {"device_id": "1102"}),
    ("battery", "device-battery-low", "warning", {"device_id": "1102"}),
    ("ebrake", "device-safety-triggered", "error", {"device_id": "04C3", "safety_type": "ebrake_triggered"}),
    ("stall", "device-safety-triggered", "warning", {"device_id": "04C3", "safety_type": "stall_detected"}),
    ("unplug", "device-disconnected", "warning", {"device_id": "04C3"}),
]


@pytest.mark.parametrize(("fault", "name", "level", "data"), EVENTS, ids=[e[0] for e in EVENTS])
def test_faults_of_devices_are_events_and_change_the_state(service, fault, name, level, data):
    with client(service) as wire, client(service, "events_port") as events:
        told(wire)
        service.fail(fault)
        event = told(events)
        assert (event["name"], event["category"], event["level"]) == (name, "device", level)
        assert data.items() <= event["data"].items()
        wire.send(command([0, 0, 1]))
        state = told(wire)
        grip = state["wireless_verse_grip"][0]
        assert (state["inverse3"] == []) == (fault == "unplug")
        assert grip["status"]["awake"] == (fault != "sleep")
        assert (grip["state"]["battery_level"] < 0.1) == (fault == "battery")
        if fault != "unplug":
            assert state["inverse3"][0]["status"]["ready"] == (fault != "ebrake")
        assert service.force().any() == (fault != "ebrake")
        service.mend(fault)
        if fault == "ebrake":
            assert told(events)["data"]["safety_type"] == "ebrake_released"


def test_a_force_acts_at_once_if_answers_are_late_and_at_the_end_of_its_turn_if_messages_are_slow(service):
    push = {"inverse3": [{"device_id": "04C3", "commands": {"set_cursor_force": {"vector": {"x": 0, "y": 0, "z": 1}}}}]}
    for fault, share in (("late", 0.0), ("slow", 1.0)):
        with client(service) as wire:
            told(wire)
            service.fail(fault, 0.1)
            begin = time.monotonic()
            for _ in range(2):  # the second one is sent while the first has no answer
                wire.send(json.dumps(push))
            for _ in range(2):
                told(wire)
            took = time.monotonic() - begin
            acted = [t - begin for t, F in service.log if t >= begin and F.any()]
            service.mend(fault)
        assert took >= 0.1 * (1 + share)
        assert acted[0] >= 0.1 * share
        assert acted[1] >= 0.2 * share
        assert acted[1] < 0.1 or share, "before the first answer"


@pytest.mark.parametrize("body", [{"scalar": "x"}, {"scalar": None}, {"scalar": True}, [1], "x", None])
def test_a_setting_of_another_kind_is_refused(service, body):
    assert service._http("POST", "/inverse3/04C3/config/filters/damping", body)[0] == 400
    assert service._http("POST", "/inverse3/04C3/config/filters/damping", {"scalar": 1})[1]["data"] == {"scalar": 1.0}


def test_late_and_hanging_answers(service):
    with client(service) as wire:
        told(wire)
        service.fail("late", 0.1)
        begin = time.monotonic()
        wire.send(PROBE)
        told(wire)
        assert time.monotonic() - begin >= 0.1
        service.mend("late")
        service.fail("hang")
        wire.send(PROBE)
        with pytest.raises(TimeoutError):
            wire.recv(0.2)
        service.mend("hang")
        told(wire)


def test_broken_connection_and_malformed_answers(service):
    with client(service) as wire:
        told(wire)
        service.fail("malformed")
        bad = 0
        for _ in range(20):
            wire.send(PROBE)
            try:
                found = json.loads(wire.recv(5.0))
                position = found["inverse3"][0]["state"]["cursor_position"]
                assert all(np.isfinite(position[axis]) for axis in "xyz")
            except (ValueError, TypeError, KeyError, AssertionError, RecursionError):
                bad += 1
        assert bad == 20, "no answer is valid"
        service.fail("disconnect", seconds=0.01)
        with pytest.raises(ConnectionClosed):
            wire.recv(5.0)
    with client(service) as wire:
        told(wire)


def test_uncalibrated_device_and_doubled_grip(service):
    with client(service) as wire:
        told(wire)
        service.fail("uncalibrated")
        service.fail("duplicate")
        wire.send(PROBE)
        state = told(wire)
        assert state["inverse3"][0]["status"]["calibrated"] is False
        assert [g["device_id"] for k in ("wireless_verse_grip", "custom_verse_grip") for g in state[k]] == ["1102"] * 2


def test_wired_grip_and_minverse():
    grip = Grip(kind="verse_grip", id="61548")
    with StandIn(0, options=Options(minverse=True, grip=grip)) as service, client(service) as wire:
        message = told(wire)
    assert message["inverse3"][0]["config"]["type"] == "minverse"
    assert message["inverse3"][0]["config"]["device_info"]["device_type"] == 6
    has_shape(message["verse_grip"][0], {"state": {"button": bool, "hall": int, "orientation": XYZW}})


def test_no_extension_is_agreed_on(service):
    """permessage-deflate would cost time in each exchange."""
    with connect(f"ws://127.0.0.1:{service.port}", compression="deflate") as wire:
        assert wire.protocol.extensions == []


def test_a_script_begins_and_ends_faults():
    faults = (Fault.parse("ebrake@0.1+0.2"),)
    with StandIn(0, options=Options(faults=faults)) as service, client(service, "events_port") as events:
        assert [told(events)["data"]["safety_type"] for _ in range(2)] == ["ebrake_triggered", "ebrake_released"]


@pytest.mark.parametrize("text", ["hang", "late=0.02", "slow", "hang@5", "sleep@5+2"])
def test_faults_are_written_in_a_few_letters(text):
    assert Fault.parse(text).name in FAULTS


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hung", "one of late, slow, hang"),
        ("hang@soon", "cannot be read"),
        ("late=nan", "cannot be read"),
        ("hang@-1", "cannot be read"),
    ],
)
def test_faults_that_cannot_be_read_are_refused(text, words):
    with pytest.raises(DeviceError, match=words):
        Fault.parse(text)


def test_a_taken_port_and_an_unknown_dialect_are_refused(service):
    with pytest.raises(DeviceError, match="is taken"):
        StandIn(service.port).start()
    with pytest.raises(DeviceError, match=r"one of 3\.0"):
        StandIn(0, options=Options(dialect="2.9"))
    with pytest.raises(DeviceError, match="leaves none for the events"):
        StandIn(65530)
    with pytest.raises(DeviceError, match="no device 'FFFF'"):
        StandIn(0, options=Options(faults=(Fault("unplug", device="FFFF"),)))


def test_a_stopped_service_frees_its_ports(service):
    port = service.port
    service.stop()
    with socket.socket() as wire:
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        wire.bind(("127.0.0.1", port))
