"""Two drivers in one scene: one organ, two hands, each with its own thread, watchdog and end."""

import json
import time

import numpy as np
import pytest
from drivers import Still

from palpate.base.errors import DeviceError, SceneError, StateError
from palpate.cli import main
from palpate.devices import Reading
from palpate.devices.buttons import CAMERA, CLUTCH, COAG
from palpate.record.reader import Record
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.session import PairsSession

K = 400.0


def scene(right, left, apart=0.06, **changes):
    """Two tools, 10 mm above contact with the plane z = 0; a leader of None is simulated."""

    def pair(x, driver):
        at = {"xyz": [x, 0.0, 0.012]}
        leader = {} if driver is None else {"leader": {"driver": driver}}
        return {"arms": leader, "operator": {"path": [{"t": 0.0, **at}, {"t": 1.0, **at}]}}

    return Scene.model_validate(
        {
            "objects": [{"name": "organ", "plane": {}, "stiffness": K, "damping": 0.0}],
            "contact": {"radius": 0.002},
            "mapping": {"scale": 1.0},
            "stability": {"passivity": "off"},
            "pairs": {"right": pair(0.5 * apart, right), "left": pair(-0.5 * apart, left)},
            **changes,
        }
    ).with_origin("", {}, trust=True)


class Right(Still):
    """Goes down until it feels 1.5 N: also after a pause of a busy machine, after which the tool starts anew."""

    z = 0.0

    def pose(self):
        self.count += 1
        felt = np.linalg.norm(self.written[-1][1]) if self.written else 0.0
        self.z -= 1e-4 if felt < 1.5 else 0.0
        X = np.eye(4)
        X[2, 3] = self.z
        return X


class Left(Right):
    rate = 400.0


class Breaks(Right):
    broken = False

    def read(self):
        if self.broken:
            raise OSError("cable pulled")
        return self.pose()


def here(cls):
    return f"{__name__}:{cls.__name__}"


def until(true, words, most=30.0):
    end = time.monotonic() + most
    while not true():
        assert time.monotonic() < end, words
        time.sleep(0.005)


def largest(loop, since=0.0):
    return max((np.linalg.norm(F) for t, F in list(loop.driver.written) if t > since), default=0.0)


def test_two_drivers_press_one_organ_each_at_its_own_rate(tmp_path):
    session = PairsSession(scene(here(Right), here(Left)), tmp_path)
    summary = session.run(3.0)
    for name, rate in (("right", 500.0), ("left", 400.0)):
        assert session.rigs[name].scene.rates.haptic == session.pairs[name].rate == rate
        assert summary.pairs[name].peak_force_N > 1.0
    assert summary.instruments.closest_m > 0.01
    assert session.run(0.1).realtime, "a second run begins anew"


class Slow(Right):
    def read(self):
        time.sleep(0.005)
        return self.pose()


class SlowLeft(Slow):
    pass


def test_a_run_lasts_its_time_where_the_devices_miss_half_of_their_ticks():
    """By ticks it would last more than twice as long; 500 Hz are asked, and each reading takes 5 ms."""
    begin = time.monotonic()
    states = []
    summary = PairsSession(scene(here(Slow), here(SlowLeft))).run(2.0, on_progress=states.append)
    assert time.monotonic() - begin < 4.0
    assert summary.pairs["right"].ticks < 500
    assert summary.duration_s == pytest.approx(2.0, abs=0.5)
    assert max(state.t for state in states[-1].values()) == pytest.approx(2.0, abs=0.5), "the clock of the live line"


def test_one_device_unplugged_ends_its_hand_in_zero_and_leaves_the_other_untouched(tmp_path):
    session = PairsSession(scene(here(Breaks), here(Left)), tmp_path)
    session.start()
    broken, other = (session.pairs[name]._loop for name in ("right", "left"))
    until(lambda: min(largest(broken), largest(other)) > 1.0, "both press")
    broken.driver.broken = True
    until(lambda: session.pairs["right"].ended is not None, "the failure is seen")
    ended = time.monotonic()
    assert "cable pulled" in session.pairs["right"].ended
    until(lambda: largest(other, ended) > 1.0, "the other hand presses on")
    assert not broken.driver.written[-1][1].any(), "the last wrench is zero"
    assert session.pairs["left"].ended is None
    summary = session.close()
    assert any("right" in fault and "cable pulled" in fault for fault in summary.faults)
    assert not other.driver.written[-1][1].any()


def stepped(x, fails_at=None, n=1500, dt=1e-3):
    """Step two devices in turns, in exact time; a function x of a hand and a step gives its height and its way to the
    other hand [m]. Forces on the tools by the other instrument and on the hands, (2, n, 3) each [N]."""
    from palpate.devices.loop import DeviceLoop, device_scene
    from palpate.scene.together import build_pairs, capsules, join_instruments

    hands = scene("loop:one", "loop:two", stability={"passivity": "off", "force_cap": 8.0})
    rigs = build_pairs(hands)
    loops = [DeviceLoop(device_scene(rig.scene, "loop", 1.0 / dt), rig=rig) for rig in rigs.values()]
    join_instruments([loop.cycle for loop in loops], [capsules(rig) for rig in rigs.values()], 500.0, 1.0)
    for loop in loops:
        loop.start()
    other, felt = np.zeros((2, n, 3)), np.zeros((2, n, 3))
    for k in range(n):
        for i, loop in enumerate(loops):
            X = np.eye(4)
            way, height = x(i, k)
            X[0, 3], X[2, 3] = (-way, way)[i], height
            if i == 1 and fails_at is not None and k >= fails_at:
                loop.cycle.report_failure(loop.wrench)
            else:
                loop.step(1.0 + k * dt, X, None, 0.0, 0)
            felt[i, k] = loop.wrench[:3]
            other[i, k] = as_ticks(np.asarray(loop.latest()).reshape(1, -1))[0]["F_instrument_W"]
    return other, felt


def test_instruments_of_two_devices_push_each_other_with_opposite_momenta():
    """The impulses add up to zero but for the step by which a loop sees the other one late."""
    other, felt = stepped(lambda i, k: (0.03 * min(1.0, k / 1000), 0.0))
    right, left = 1e-3 * other.sum(axis=1)
    assert np.linalg.norm(right) > 0.1, "they meet"
    assert np.linalg.norm(right + left) < 0.01 * np.linalg.norm(right)
    assert other[0, -1] == pytest.approx(-other[1, -1], abs=1e-6), "at rest the forces are opposite"
    assert felt[0, -1] == pytest.approx(-felt[1, -1], abs=1e-6), "and both hands feel them"


def test_a_hand_beside_one_that_fails_feels_the_very_same_force():
    def press(i, k):
        return 0.0, -0.02 * min(1.0, k / 500) - 0.002 * np.sin(0.01 * k)

    _, felt = stepped(press)
    _, beside = stepped(press, fails_at=900)
    assert np.linalg.norm(felt[0], axis=1).max() > 2.0
    assert np.array_equal(felt[0], beside[0]), "bit by bit"
    assert not beside[1, 900:].any()


class Pushes(Still):
    """Goes down beside a block, then pushes it along x, until it feels .4 N of the hand that holds against it."""

    along = 0.0

    def pose(self):
        X = super().pose()
        felt = np.linalg.norm(self.written[-1][1]) if self.written else 0.0
        self.along += 1e-4 if self.count > 400 and felt < 0.4 else 0.0
        X[0, 3] = self.along
        return X


@pytest.mark.parametrize("other", [Still, None])
def test_one_hand_pushes_a_block_against_the_tool_of_the_other(tmp_path, other):
    """Both on devices, or one simulated: the block carries the force from hand to hand, and earns nothing."""
    pytest.importorskip("mujoco")
    hands = scene(None if other is None else here(other), here(Pushes), apart=0.08)
    data = hands.model_dump(mode="json", exclude_unset=True)
    for name, x in (("right", 0.04), ("left", -0.04)):
        path = [{"t": 0.0, "xyz": [x, 0.0, 0.05]}, {"t": 0.3, "xyz": [x, 0.0, 0.02]}, {"t": 9.0, "xyz": [x, 0.0, 0.02]}]
        data["pairs"][name]["operator"] = {"path": path}
        data["pairs"][name]["arms"]["follower"] = {"model": "psm_prograsp", "base": {"xyz": [x, 0.0, 0.19]}}
    data["objects"][0]["pose"], data["stability"] = {"xyz": [0.0, 0.0, -0.1]}, {}
    data["bodies"] = [
        {"name": "floor", "fixed": True, "parts": [{"box": [0.3, 0.3, 0.01], "pose": {"xyz": [0, 0, -0.005]}}]},
        {"name": "block", "mass": 0.02, "parts": [{"box": [0.03, 0.03, 0.03]}], "pose": {"xyz": [0, 0, 0.015]}},
    ]
    session = PairsSession(Scene.model_validate(data).with_origin("", {}, trust=True), tmp_path)
    assert [tool.name for tool in session.world.tools] == ["right", "left"]
    summary = session.run(4.0)
    felt = {name: Record.open(one.record).ticks for name, one in summary.pairs.items()}
    end = {name: ticks["F_instrument_W"][-200:, 0].mean() for name, ticks in felt.items()}
    assert end["right"] > 0.2, "pushed along x"
    assert end["left"] < -0.2, "the block resists"
    assert min(ticks["energy_port"].min() for ticks in felt.values()) > -0.000501, "the allowance of the layer"
    assert summary.instruments.momentum_error_N_s is None, "the block and the floor take a part of the impulses"


def test_a_device_and_a_simulated_arm_share_a_scene(tmp_path):
    summary = PairsSession(scene(here(Right), None), tmp_path).run(3.0)
    assert summary.pairs["right"].peak_force_N > 1.0
    assert summary.pairs["left"].peak_force_N == pytest.approx(0.0, abs=1e-9), "its hand rests in the air"
    assert summary.pairs["left"].ticks > 100


@pytest.mark.parametrize("other", ["loop", "driver"])
def test_a_loop_of_ones_own_is_one_hand_of_two(tmp_path, other):
    """Two in one thread, or one beside a driver: instruments meet, one record, and nothing without a session."""
    import palpate

    hands = scene(None, None if other == "loop" else here(Still), apart=0.03, instruments={"stiffness": 500})
    own = ("right", "left") if other == "loop" else ("right",)
    plants = {name: palpate.OwnLoop(hands.pair(name), rate=1000.0) for name in own}
    right = plants["right"]
    with pytest.raises(DeviceError, match="no session runs this loop"):
        right.step(0.0, np.eye(4))
    with PairsSession(hands, tmp_path, plants=plants) as session:
        with pytest.raises(StateError, match="a loop of your own"):
            session.step()
        session.start()
        begin, way, felt = time.monotonic(), 0.0, {name: np.zeros(3) for name in plants}
        while (t := time.monotonic() - begin) < 20.0 and np.linalg.norm(felt["right"]) < 0.5:
            way += 1e-5
            for name, plant in plants.items():
                X = np.eye(4)
                X[0, 3] = -way if name == "right" else way
                felt[name] = plant.step(t, X)[:3]
            time.sleep(0.0005)
        assert felt["right"][0] > 0.3, "the instrument of the left hand pushes back"
        if other == "loop":
            assert felt["left"] == pytest.approx(-felt["right"], abs=0.1)
        with pytest.raises(DeviceError, match="X must have shape"):
            right.step(t + 0.01, np.eye(3))
        summary = session.close()
    with pytest.raises(DeviceError, match="no session runs this loop"):
        right.step(t + 1.0, np.eye(4))
    assert Record.open(summary.pairs["right"].record).ticks["F_instrument_W"][:, 0].max() > 0.3


class Absent(Still):
    def open(self):
        raise OSError("no such device")


def test_a_second_device_that_does_not_open_leaves_no_force_on_the_first(tmp_path):
    session = PairsSession(scene(here(Right), here(Absent)), tmp_path)
    with pytest.raises(DeviceError, match="no such device"):
        session.run(1.0)
    assert not session.running
    first = session.pairs["right"]._loop.driver
    assert first.closed
    assert not first.written[-1][1].any()


class Buttons(Still):
    bits = 0

    def read(self):
        return Reading(self.pose(), None, 0.0, self.bits)


def test_buttons_of_a_device_reach_the_console_of_both_hands(tmp_path):
    session = PairsSession(scene(here(Buttons), here(Left)), tmp_path)
    driver, seen = session.pairs["right"]._loop.driver, []
    session.console.on_change(lambda pedal, down: seen.append((pedal, down)))
    session.start()
    for bits, count in ((CAMERA, 1), (CAMERA | COAG, 2), (CLUTCH, 4)):
        driver.bits = bits
        until(lambda count=count: len(seen) == count, seen)
    session.close()
    assert seen == [("camera", True), ("coag", True), ("camera", False), ("coag", False)]


def test_a_device_of_the_command_line_has_place_and_axes_of_its_pairs_leader():
    """As in a scene with one hand: turned by 90 degrees, a device that moves along its x moves the tool along y."""
    base = {"xyz": [-0.3, 0.2, 0.2], "rpy_deg": [0, 0, 90]}
    hands = scene(None, None)
    data = hands.model_dump(mode="json", exclude_unset=True)
    data["pairs"]["left"]["arms"] = {"leader": {"base": base}}
    made = Scene.model_validate(data).with_driver(here(Left), "left").with_driver(here(Right), "right")
    rig = PairsSession(made.with_origin("", {}, trust=True)).rigs["left"]
    assert rig.arms.X_WL[:3, 3] == pytest.approx(base["xyz"])
    assert rig.arms.X_WL[:3, 0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12), "x of the device"


def test_palpate_check_takes_two_devices_without_places(tmp_path, capsys):
    file = tmp_path / "two.yaml"
    file.write_text(scene("simulated", "haply").to_yaml())
    assert main(["check", str(file)]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    ("drivers", "changes", "error", "words"),
    [(("loop", here(Left)), {}, DeviceError, "pair right: this scene is driven by a loop of your own"),
     (("nowhere:Device", here(Left)), {}, DeviceError, "pair right: driver 'nowhere:Device' cannot be imported"),
     ((here(Right), here(Left)), {"graspable": {"name": "rod", "length": 0.03, "radius": 0.001}}, SceneError, "rod"),
     (("./a.so:x", "./a.so:y"), {}, DeviceError, "pair right")],
)  # fmt: skip
def test_what_cannot_run_is_refused_by_the_name_of_its_pair(drivers, changes, error, words):
    with pytest.raises(error, match=words):
        PairsSession(scene(*drivers, **changes))


def test_a_device_has_no_lockstep():
    session = PairsSession(scene(here(Right), None))
    for act in (lambda: session.run(1.0, realtime=False), session.step, session.console.swap):
        with pytest.raises(StateError):
            act()


haply = pytest.importorskip("palpate.devices.haply.stand_in", reason="the stand-in needs the extra haply")


@pytest.fixture
def service():
    with haply.StandIn(0, options=haply.Options(more=("04C4",), idle_after=5.0)) as made:
        yield made


def on(service, id, **options):
    from palpate.scene.haply import HaplySection

    return HaplySection(url=f"ws://127.0.0.1:{service.port}", id=id, rate=200.0, **options).to_text()


def pressing(service, session, ids):
    until(lambda: all(np.linalg.norm(service.force(id=id)) > 0.4 for id in ids), session.states)


def test_two_haplys_of_one_service_are_named_by_serial_number_and_one_can_be_unplugged(service, tmp_path):
    hands = scene(on(service, "04C3", grip="1102"), on(service, "04C4", grip="1103"))
    session = PairsSession(hands, tmp_path)
    assert session.pairs["left"].plant.hardware == ("the Haply device 04C4", "the grip 1103 of Haply")
    assert service.devices["04C3"].config.handedness != service.devices["04C4"].config.handedness
    session.start()
    pressing(service, session, ["04C3", "04C4"])
    service.fail("unplug", device="04C4")
    until(lambda: session.pairs["left"].ended is not None, "it is seen", most=5.0)
    assert "04C4 vanished" in session.pairs["left"].ended
    until(lambda: not service.force(id="04C4").any(), "its motors have no force", most=2.0)
    assert session.pairs["right"].ended is None
    pressing(service, session, ["04C3"])
    summary = session.close()
    assert not service.force(id="04C3").any(), "zero at the end"
    assert any("left" in fault and "vanished" in fault for fault in summary.faults)


@pytest.mark.parametrize(
    ("right", "left", "words"),
    [({"id": "04C3", "grip": "none"}, {"id": "04C3", "grip": "1102"}, "both have the Haply device 04C3"),
     ({"id": "04C3"}, {"id": "04C4"}, "both have the grip 1102"),
     ({"id": None}, {"id": "04C4"}, "pair right: the service .* knows 2 devices")],
)  # fmt: skip
def test_one_device_or_grip_for_two_hands_is_refused(service, right, left, words):
    with pytest.raises((DeviceError, SceneError), match=words):
        PairsSession(scene(on(service, **right), on(service, **left)))


def test_palpate_run_feels_two_hands_on_the_devices_that_it_names(service, tmp_path, capsys):
    file = tmp_path / "two.yaml"
    file.write_text(scene(None, None).to_yaml())
    leaders = [f"{hand}={on(service, id, grip=grip)}" for hand, id, grip in
               (("right", "04C3", "1102"), ("left", "04C4", "1103"))]  # fmt: skip
    options = [word for one in leaders for word in ("--leader", one)]
    json_file = tmp_path / "run.json"
    command = [
        "run",
        str(file),
        "--headless",
        "--duration",
        "1",
        "--out",
        str(tmp_path / "runs"),
        "--json",
        str(json_file),
    ]
    assert main([*command, *options]) == 0
    found = json.loads(json_file.read_text())
    assert {name: one["realtime"] for name, one in found["pairs"].items()} == {"right": True, "left": True}
    assert main([*command, "--leader", "middle=haply"]) == 2
    assert "names no pair of the scene" in capsys.readouterr().err
    service.fail("unplug", device="04C4")
    assert main([*command, *options]) == 2, "a device that is not there is refused"
