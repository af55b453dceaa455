"""Each field of the service's messages as a number, a text, a truth value, a list, an object, null, and left out."""

import copy
import json
import time

import numpy as np
import pytest

pytest.importorskip("websockets", reason="the stand-in needs the extra haply")

from test_haply import LONG, on, press

from palpate import _haply
from palpate.base.errors import DeviceError
from palpate.devices.haply import driver, stand_in
from palpate.devices.haply.messages import Config, Grip, State, device_entry, event, grip_entry
from palpate.devices.haply.service import Address
from palpate.devices.haply.stand_in import Options, StandIn
from palpate.scene.haply import HaplySection
from palpate.session import Session

LEFT_OUT = object()
KINDS = {"left out": LEFT_OUT, "null": None, "true": True, "7": 7, "-1": -1, "0.5": 0.5, "text": "1", "list": [1],
         "object": {"x": 1}, "whole number beyond 64 bits": 2**70}  # fmt: skip


def message(config=True):
    """The inventory, or a state, of a device with a grip."""
    state = State(np.array([0.0, 0.1, 0.2]), np.zeros(3), np.zeros(3))
    grip = Grip()
    return {
        "session_id": 7,
        "inverse3": [device_entry("04C3", False, Config() if config else None, state, "3.5")],
        grip.kind: [grip_entry(grip, grip.kind, config, "3.5")],
    }


def paths(value, before=()):
    """Paths of all fields."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path for key, inner in items for path in ((*before, key), *paths(inner, (*before, key)))]


def changed(value, path, kind):
    out = copy.deepcopy(value)
    at = out
    for key in path[:-1]:
        at = at[key]
    if kind is LEFT_OUT:
        del at[path[-1]]
    else:
        at[path[-1]] = kind
    return out


class Wire:
    """Both messages of a service, without a network."""

    def __init__(self, *messages):
        self.messages, self.sent = [json.dumps(one) for one in messages], []

    def receive(self, seconds):
        return self.messages.pop(0)

    def send(self, text):
        self.sent.append(json.loads(text))


def prepared(inventory):
    return driver._prepare(Wire(inventory, inventory), Address(), HaplySection(gravity=None), (3, 5))


USED = ("inverse3", "device_id", "config", "device_info", "basis", "permutation", "mount", "filters", "damping",
        "scalar", "status", "calibrated", "state", "transform")  # fmt: skip


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_the_inventory_is_taken_or_refused_with_words_whatever_a_field_is(kind):
    for path in paths(message()):
        try:
            found = prepared(changed(message(), path, kind)).id
        except DeviceError:
            found = ""
        if not found:
            assert path[-1] in USED or isinstance(path[-1], int) or "grip" in path[0], path
        else:
            assert found == (str(kind) if path == ("inverse3", 0, "device_id") else "04C3"), path


@pytest.mark.parametrize(
    ("path", "kind", "taken"),
    [(("status", "calibrated"), 1, True), (("status", "calibrated"), 0, False),
     (("status", "calibrated"), "yes", False), (("status", "calibrated"), LEFT_OUT, False),
     (("config", "mount"), None, True), (("config", "mount"), [1], False),
     (("config", "mount"), {"position": {"x": 0, "y": 0}}, True), (("config", "mount"), {"scale": {"x": "1"}}, False),
     (("config", "mount"), {"position": {"x": 1}}, False), (("config", "basis"), LEFT_OUT, True),
     (("config", "basis"), "XYZ", False), (("config", "basis", "permutation"), 3, False),
     (("config", "filters", "damping", "scalar"), 0, True), (("config", "filters", "damping", "scalar"), "0", False),
     (("config", "device_info", "device_type"), "inverse3x", True), (("device_id",), 1219, True),
     (("device_id",), True, False), (("device_id",), LEFT_OUT, False), (("device_id",), 2**70, False)],
)  # fmt: skip
def test_what_the_driver_needs_of_the_inventory(path, kind, taken):
    given = changed(message(), ("inverse3", 0, *path), kind)
    if taken:
        assert prepared(given).id in ("04C3", "1219")
    else:
        with pytest.raises(DeviceError):
            prepared(given)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_state_is_read_as_it_is_or_not_at_all_whatever_a_field_is(kind):
    refused = set()
    for path in paths(message(False)):
        reader = _haply.Reader("04C3", "1102", "wireless_verse_grip")
        found = reader.read(json.dumps(changed(message(False), path, kind)).encode())
        if found is None:
            refused.add(path[-1])
        elif "cursor_position" in path:
            assert found[0][("x", "y", "z").index(path[-1])] == kind
    allowed = {"inverse3", 0, "device_id", "state", "status", "calibrated", "ready", "cursor_position",
               "cursor_velocity", "x", "y", "z"}  # fmt: skip
    assert refused <= allowed
    if kind is LEFT_OUT or kind is None:
        assert {"cursor_position", "x"} <= refused
        assert not refused & {"status", "calibrated", "ready", "cursor_velocity"}
    elif kind in (7, -1, 0.5, 2**70) and kind is not True:
        assert "x" not in refused
    else:
        assert {"cursor_position", "x"} <= refused


@pytest.mark.parametrize(("given", "id"), [("7", "7"), (7, "7"), (0, "0"), (2**63, str(2**63))])
def test_an_id_may_be_a_number(given, id):
    text = json.dumps(changed(message(False), ("inverse3", 0, "device_id"), given)).encode()
    assert _haply.Reader(id, "", "").read(text) is not None
    assert _haply.Reader("70", "", "").read(text) is None
    lost = json.dumps(event("device-disconnected", "error", "", device_id=given)).encode()
    assert _haply.Reader(id, "", "").read_event(lost) != 0
    assert _haply.Reader("70", "", "").read_event(lost) == 0


def test_a_service_whose_ids_are_numbers_is_felt_and_hears_its_number(monkeypatch, tmp_path):
    """Numbers in inventory, states, grips and events; commands carry the number."""

    def numbered(made):
        return lambda *words, **more: (entry := made(*words, **more)) | {"device_id": int(entry["device_id"])}

    def told(*words, **data):
        return event(*words, **{key: int(value) if key == "device_id" else value for key, value in data.items()})

    monkeypatch.setattr(stand_in, "device_entry", numbered(device_entry))
    monkeypatch.setattr(stand_in, "grip_entry", numbered(grip_entry))
    monkeypatch.setattr(stand_in, "event", told)
    service = StandIn(0, options=Options(id="7", idle_after=LONG))
    with service, Session(on(service, id="7", grip="1102"), tmp_path) as session:
        session.start()
        press(session, service)
        command = json.loads(service.received[-1])["inverse3"][0]
        assert command["device_id"] == 7
        assert list(command["commands"]["set_cursor_force"]["vector"]) == ["x", "y", "z"]
        service.fail("unplug")
        end = time.monotonic() + 5.0
        while session._loop.fault() is None and time.monotonic() < end:
            time.sleep(0.01)
        summary = session.close()
    assert any("device 7 vanished" in fault for fault in summary.faults), summary.faults
