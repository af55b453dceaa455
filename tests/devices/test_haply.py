"""The driver of Haply devices beside the stand-in: forces, what it refuses, and zero force by name of each fault."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from test_haptics import CAP, scene

pytest.importorskip("websockets", reason="the stand-in needs the extra haply")

from scipy.spatial.transform import Rotation

from palpate import rebuild
from palpate.base.errors import DeviceError
from palpate.devices.haply import stand_settings
from palpate.devices.haply.driver import Haply
from palpate.devices.haply.messages import DIALECTS, Grip
from palpate.devices.haply.service import Address
from palpate.devices.haply.stand_in import MIDDLE, Options, StandIn
from palpate.record.reader import Record
from palpate.scene import Scene
from palpate.scene.haply import HaplySection
from palpate.session import Session

LONG = 5.0
"""Silence after which the stand-in's motors are idle, here so long that the zero of the force is ours [s]."""


@pytest.fixture
def service(request):
    with StandIn(0, options=Options(**{"idle_after": LONG, **getattr(request, "param", {})})) as made:
        yield made


def haply(service, **options):
    return HaplySection(url=f"ws://127.0.0.1:{service.port}", rate=500.0, **options).to_text()


def on(service, **options):
    """A scene of a plane below the tool, on the device of the service."""
    return scene(arms={"leader": {"driver": haply(service, **options)}}, mapping={"scale": 1.0})


def press(session, service, most=20.0):
    """Wait until the device is pushed with more than 0.4 N."""
    end = time.monotonic() + most
    while np.linalg.norm(service.force()) < 0.4:
        assert time.monotonic() < end, session.state
        time.sleep(0.002)


@pytest.mark.parametrize("service", [{"dialect": d} for d in DIALECTS], ids=DIALECTS, indirect=True)
def test_each_version_of_the_service_feels_the_plane_and_ends_with_zero(service, tmp_path):
    session = Session(on(service), tmp_path)
    summary = session.run(4.0)
    forces = np.array([F for _, F in service.log])
    assert 0.5 < np.linalg.norm(forces, axis=1).max() <= CAP * (1 + 1e-6)
    assert forces[:, 2].min() >= -1e-6, "upwards, out of the plane"
    assert not forces[-1].any()
    assert not service.ignored, "no key that this version does not know"
    key = b'"vector"' if service.options.dialect == "3.5" else b'"values"'
    assert key in service.received[-1]
    assert not session.failed
    assert summary.peak_force_N == pytest.approx(np.linalg.norm(forces, axis=1).max(), rel=1e-4)
    ticks = Record.open(summary.record).ticks
    assert len(ticks) / summary.duration_s == pytest.approx(500.0, rel=0.2)


@pytest.mark.parametrize(
    "buttons",
    [{"a": True, "b": True, "c": False}, {"down": True, "up": True, "right": False, "left": False},
     {"a": False, "down": True, "up": True}],
    ids=["versegrip", "ruko", "both"],
)  # fmt: skip
def test_pose_comes_from_position_and_grip_and_a_force_keeps_its_axes(service, buttons):
    turn = Rotation.from_euler("xyz", [20, -30, 40], degrees=True)
    service.grip = Grip(orientation=tuple(turn.as_quat()), buttons=buttons)
    driver = Haply(haply(service).removeprefix("haply:"))
    driver.open()
    X, _, gripper, pressed = driver.read()
    assert X[:3, :3] == pytest.approx(turn.as_matrix(), abs=1e-9)
    assert X[:3, 3] == pytest.approx(MIDDLE, abs=0.07)
    assert (gripper, pressed) == (0.0, 0x301), "a is the clutch, b closes the gripper; both are pressed"
    driver.write(np.array([0.1, -0.2, 0.3, 0.0, 0.0, 0.0]))
    driver.read()
    assert service.log[-1][1] == pytest.approx([0.1, -0.2, 0.3])
    driver.close()
    time.sleep(0.05)
    assert not service.log[-1][1].any(), "zero at the end"


@pytest.mark.parametrize(
    ("grip", "list"),
    [(Grip(), "wireless_verse_grip"), (Grip(kind="verse_grip", id="61548"), "verse_grip"),
     (Grip(kind="custom_verse_grip", id="1402"), "custom_verse_grip"), (Grip(doubled=True), "wireless_verse_grip"),
     (Grip(awake=False), ""), (None, "")],
    ids=["wireless", "wired", "ruko", "twice", "asleep", "none"],
)  # fmt: skip
def test_the_first_grip_that_is_awake_gives_the_orientation(grip, list):
    with StandIn(0, options=Options(grip=grip)) as service:
        driver = Haply(haply(service).removeprefix("haply:"))
        driver.open()
        assert driver.found.list == list
        assert driver.found.grip == (grip.id if list else "")
        driver.read()


@pytest.mark.parametrize("law", ["rate", "drift"])
def test_the_workspace_lies_around_the_first_position_not_around_the_base(service, law):
    """The base is 0.2 m away from the workspace: around it, the tool would run away by itself."""
    mapping = Session(scene(arms={"leader": {"driver": haply(service)}}, mapping=law)).rig.scene.mapping
    assert mapping.workspace == pytest.approx((0.115,) * 3)
    assert mapping.centre is None
    given = {"law": law, "workspace": [0.1, 0.1, 0.1], "centre": [0.0, -0.1, 0.1]}
    kept = Session(scene(arms={"leader": {"driver": haply(service)}}, mapping=given)).rig.scene.mapping
    assert kept.centre == (0.0, -0.1, 0.1)


def test_settings_are_made_and_read_back(service):
    driver = Haply(haply(service, gravity=0.5, damping=0.25, force_gate=0.1).removeprefix("haply:"))
    driver.open()
    assert service.config.gravity == {"enabled": True, "scaling_factor": 0.5}
    assert (service.config.damping, service.config.force_gate) == (0.25, 0.1)
    assert driver.found.settings["filters"] == {"damping": {"scalar": 0.25}, "force_gate": {"gain": 0.1}}
    driver.close()


REFUSED = [
    ({}, lambda s: s.fail("uncalibrated"), {}, "is not calibrated.*mirrored"),
    ({}, lambda s: s.fail("unplug"), {}, "knows no Inverse3"),
    ({}, lambda s: None, {"id": "FFFF"}, "knows no device 'FFFF'.*one of 04C3"),
    ({}, lambda s: None, {"grip": "77"}, "knows no grip '77'.*it knows 1102"),
    ({}, lambda s: setattr(s.config, "mount", {"scale": {"x": 2.0, "y": 2.0, "z": 2.0}}), {}, "has a mount of"),
    ({"dialect": "3.4"}, lambda s: setattr(s.config, "basis", "ZXY"), {}, "has the axes 'ZXY'"),
    ({"dialect": "3.1"}, lambda s: None, {"force_gate": 0.1}, "services before 3.5 have no filters"),
]


@pytest.mark.parametrize(("like", "change", "options", "words"), REFUSED, ids=[words[:14] for *_, words in REFUSED])
def test_a_device_that_would_give_wrong_forces_is_refused_with_words(like, change, options, words):
    with StandIn(0, options=Options(**like)) as service:
        change(service)
        with pytest.raises(DeviceError) as error:
            Session(on(service, **options))
        import re

        assert re.search(words, str(error.value), re.DOTALL)
        assert not any(F.any() for _, F in service.log)


def test_a_service_that_does_not_keep_a_setting_is_refused(service, monkeypatch):
    monkeypatch.setattr(stand_settings, "set_setting", lambda config, key, value: True)
    with pytest.raises(DeviceError, match=r"gravity compensation is .* after it was set to"):
        Session(on(service, gravity=0.3))


def test_no_service_is_told_with_the_mend():
    with socket.socket() as wire:
        wire.bind(("127.0.0.1", 0))
        port = wire.getsockname()[1]
    with pytest.raises(DeviceError, match="no Haply Inverse Service answers") as error:
        Haply(f"url=ws://127.0.0.1:{port}").native()
    assert "palpate device stand-in haply" in error.value.mend


def test_a_clone_without_boost_is_told_what_to_do(monkeypatch):
    def refuse(name):
        raise ImportError(f"palpate.{name} is not compiled")

    monkeypatch.setattr(rebuild, "extension", refuse)  # otherwise it would compile in this clone, beside other tests
    monkeypatch.setitem(sys.modules, "palpate._haply", None)
    monkeypatch.delattr("palpate._haply", raising=False)
    with pytest.raises(DeviceError, match="cannot be compiled") as error:
        Haply("").native()
    assert "make setup" in error.value.mend


def silence(session, service, fault, value=0.02):
    """Press, let the fault begin; time [s] until the rendered force, as recorded, and that on the motors are zero.

    A service that hangs takes no force: nobody waits for its motors.
    """
    press(session, service)
    begin = time.monotonic()
    service.fail(fault, value)
    rendered = motors = None
    while (rendered is None or (motors is None and fault != "hang")) and time.monotonic() - begin < 1.0:
        if rendered is None and session.state.force == 0.0:
            rendered = time.monotonic() - begin
        if motors is None and not service.force().any():
            motors = time.monotonic() - begin
        time.sleep(0.0005)
    return rendered, motors


FAULTS = [
    ("late", "did not answer in time", True),
    ("slow", "did not answer in time", True),
    ("malformed", "no valid state", True),
    ("ebrake", "emergency brake", True),
    ("uncalibrated", "not calibrated", True),
    ("stall", "motor stalled", True),
    ("unplug", "vanished", False),
    ("disconnect", "closed the connection|connection to the service is broken", False),
]


@pytest.mark.parametrize(("fault", "words", "stays"), FAULTS, ids=[f[0] for f in FAULTS])
def test_each_fault_of_the_service_gives_zero_force_by_name(service, fault, words, stays):
    import re

    with Session(on(service)) as session:
        session.start()
        rendered, motors = silence(session, service, fault)
        assert rendered is not None, "the session shows zero force"
        assert motors is not None or not stays, "and sends it"
        time.sleep(0.05)
        assert (session._loop.fault() is None) == stays
        service.mend(fault)
        summary = session.close()
    assert any(re.search(words, fault) for fault in summary.faults), summary.faults


def test_a_hanging_service_gives_zero_force_at_once_and_ends_the_session_after_a_second(service):
    with Session(on(service)) as session:
        session.start()
        rendered, _ = silence(session, service, "hang")
        assert rendered is not None
        begin = time.monotonic()
        while session._loop.fault() is None and time.monotonic() - begin < 5.0:
            time.sleep(0.01)
        assert "gave no valid state for 1 s" in session._loop.fault()
        service.mend("hang")
        time.sleep(0.05)
        assert not service.log[-1][1].any(), "the last command is zero"
        summary = session.close()
    assert any("did not answer in time" in fault for fault in summary.faults)


@pytest.mark.parametrize("fault", ["late", "slow"])
def test_a_service_that_stays_slow_gets_no_further_force(service, fault):
    """One message with a force is under way when it begins; after the zero none follows until answers come in time."""
    with Session(on(service)) as session:
        session.start()
        press(session, service)
        service.fail(fault, 0.02)
        begin = time.monotonic()
        time.sleep(0.5)
        after = [t - begin for t, F in list(service.log) if t > begin and F.any()]
        assert len(after) <= 2, "one that was sent before, and one that was under way"
        assert not session.failed
        service.mend(fault)
        press(session, service)
        session.close()


def test_a_short_hang_is_survived_and_the_force_returns(service):
    with Session(on(service)) as session:
        session.start()
        rendered, _ = silence(session, service, "hang")
        assert rendered < 0.5, "well before the second after which the session ends"
        service.mend("hang")
        end = time.monotonic() + 2.0
        while service.force().any():
            assert time.monotonic() < end, "the zero that was sent meanwhile is the next message that the service reads"
        press(session, service)
        assert session._loop.fault() is None
        session.close()


def test_a_sleeping_grip_is_told_and_the_force_stays(service):
    with Session(on(service)) as session:
        session.start()
        press(session, service)
        service.fail("sleep")
        service.fail("battery")
        time.sleep(0.1)
        press(session, service)
        summary = session.close()
    assert any("grip fell asleep" in fault for fault in summary.faults)
    assert any("battery of the grip" in fault for fault in summary.faults)


def test_a_killed_service_gives_zero_force_by_name(tmp_path):
    command = [sys.executable, "-m", "palpate", "device", "stand-in", "haply", "--port", "0", "--idle-after", "5"]
    service = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        line = service.stdout.readline()
        url = next(word.rstrip(",") for word in line.split() if word.startswith("ws://"))
        driver = HaplySection(url=url, rate=500.0).to_text()
        with Session(scene(arms={"leader": {"driver": driver}}), tmp_path) as session:
            session.start()
            end = time.monotonic() + 20.0
            while session.state.force < 0.4 and time.monotonic() < end:
                time.sleep(0.002)
            os.kill(service.pid, signal.SIGKILL)
            begin = time.monotonic()
            while session._loop.fault() is None and time.monotonic() - begin < 2.0:
                time.sleep(0.0005)
            fault = session._loop.fault()
            summary = session.close()
    finally:
        service.kill()
        service.wait()
    assert fault is not None
    assert "the force was set to zero" in fault
    ticks = Record.open(summary.record).ticks
    assert not ticks["F_H_L"][-1].any()
    assert np.linalg.norm(ticks["F_H_L"], axis=1).max() > 0.4


def test_every_exit_ends_in_zero(service):
    """A session that is left without a close, by an exception."""

    def leave():
        with Session(on(service)) as session:
            session.start()
            press(session, service)
            raise KeyError

    with pytest.raises(KeyError):
        leave()
    time.sleep(0.05)
    assert not service.log[-1][1].any()


def test_a_scene_names_the_driver_with_options_and_a_record_finds_it_again(tmp_path):
    text = "objects: [{name: ball, sphere: {radius: 0.03}, stiffness: 400}]\narms: {leader: {driver: %s}}\n"
    file = tmp_path / "scene.yaml"
    file.write_text(text % "{haply: {id: 04C3, rate: 1000 Hz, grip: none}}")
    found = Scene.load(file)
    assert found.arms.leader.driver == "haply:id=04C3,grip=none,rate=1000.0"
    assert Scene.parse(found.to_yaml()).arms.leader.driver == found.arms.leader.driver
    file.write_text(text % "haply")
    assert Scene.load(file).arms.leader.driver == "haply"
    for wrong, words in (("{haply: {port: 3}}", "port"), ("{omega: {}}", "no options for omega")):
        file.write_text(text % wrong)
        with pytest.raises(Exception, match=words):
            Scene.load(file)


class Strange:
    """A service of the package websockets, independent of the stand-in; each connection is served by a function."""

    def __init__(self, serve):
        from websockets.sync.server import serve as listen

        self._server = listen(serve, "127.0.0.1", 0, compression=None)
        self.port = self._server.socket.getsockname()[1]
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def device(self):
        from palpate import _haply
        from palpate.devices.haply import service

        connection = service.websocket(Address("127.0.0.1", self.port))
        return _haply.Device(
            connection, None, device="04C3", address='"04C3"', grip="", list="", vector=True, rate=500.0,
            force_max=3.0, workspace=0.1,
        )  # fmt: skip

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._server.shutdown()


def answer(x, **status):
    """A state at x, with keys in an order of its own and integers for numbers."""
    state = {"cursor_velocity": {"z": 0, "y": 0, "x": 0}, "cursor_position": {"z": 0, "x": x, "y": 0}}
    return json.dumps({"news": [1], "inverse3": [{**status, "state": state, "device_id": "04C3"}]})


def test_messages_that_nobody_asked_for_leave_no_delay():
    """With one further message each time the state would be as old as half of all ticks."""

    def twice(wire):
        for n, _ in enumerate(wire):
            wire.send(answer(n))
            wire.send(answer(n))

    with Strange(twice) as service:
        device, X, lags = service.device(), np.eye(4), []
        for n in range(300):
            if device.read(X) is not None and n > 0:
                lags.append(device.exchanges - 1 - X[0, 3])
            device.write(np.zeros(6))
            time.sleep(0.001)
    assert len(lags) > 200
    assert max(lags) <= 1.0


@pytest.mark.parametrize(
    ("statuses", "read"),
    [([{}, {}], [True, True]), ([{"status": {"calibrated": True, "ready": True}}, {}], [True, True]),
     ([{"status": {"calibrated": False}}, {}], [False, False]),
     ([{"status": {"ready": False}}, {}, {"status": {"ready": True}}], [False, False, True]),
     ([{"status": "idle"}], [False]), ([{"status": {"calibrated": 2}}], [False]),
     ([{"status": {"calibrated": 0}}, {"status": {"calibrated": 1, "ready": None}}], [False, True])],
    ids=["never", "once", "not calibrated", "ready again", "a text", "a number", "1 for true"],
)  # fmt: skip
def test_a_status_that_a_message_leaves_out_is_the_last_one(statuses, read):
    def serve(wire):
        for n, _ in enumerate(wire):
            wire.send(answer(n, **statuses[min(n, len(statuses) - 1)]))

    with Strange(serve) as service:
        device, X, found = service.device(), np.eye(4), []
        for _ in read:
            found.append(device.read(X) is not None)
            device.write(np.zeros(6))
    assert found == read


def test_gravity_compensation_can_be_left_alone(service):
    service.config.gravity = {"enabled": True, "scaling_factor": 0.7}
    section = HaplySection(url=f"ws://127.0.0.1:{service.port}", gravity=None)
    assert section.to_text().endswith("gravity=none")
    assert HaplySection.from_text(section.to_text().removeprefix("haply:")).gravity is None
    driver = Haply(section.to_text().removeprefix("haply:"))
    driver.open()
    driver.close()
    assert service.config.gravity == {"enabled": True, "scaling_factor": 0.7}


def test_exchange_is_timed_beside_a_bare_echo(service, tmp_path, capsys):
    from palpate.cli import main

    name, file = haply(service), tmp_path / "exchange.json"
    assert main(["device", "bench", name, "--exchange", "0.5", "--json", str(file)]) == 0
    found = json.loads(file.read_text())
    assert 0.0 < found["echo_p50_us"] <= found["echo_p99_us"]
    assert 0.0 < found["trip_p50_us"] <= found["trip_p99_us"]
    assert found["ticks"] > 50
    assert 0 <= found["missed"] <= 250
    assert found["rate_Hz"] == 500.0
    assert found["echo_ticks"] == 250
    assert 0 <= found["echo_missed"] <= 5000
    assert found["late"] < found["ticks"]
    service.fail("late", 0.004)
    assert main(["device", "bench", name, "--exchange", "0.5", "--json", str(file)]) == 0
    found = json.loads(file.read_text())
    assert found["late"] > 0.9 * found["ticks"], "two periods late: each tick has waited for its answer"
    assert main(["device", "bench", "simulated", "--exchange", "1"]) == 2
    assert "--exchange is for the driver haply" in capsys.readouterr().err
