"""One session for every plant: a simulated arm, a driver, both in a scene of two pairs; what one cannot is refused."""

import numpy as np
import pytest

import palpate
from palpate.base.errors import DeviceError, StateError
from palpate.devices import Driver
from palpate.scene.rig import build

BALL = {"name": "ball", "sphere": {"radius": 0.03}, "stiffness": 400.0}
FAR = {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.04]}, {"t": 1.0, "xyz": [0.0, 0.0, 0.04]}]}


class Sinks(Driver):
    """A handle that moves down by 14 mm in half a second."""

    rate = 500.0
    force_max = 3.0

    def __init__(self):
        self.read_, self.strongest = 0, 0.0

    def open(self):
        pass

    def close(self):
        pass

    def read(self):
        X = np.eye(4)
        X[2, 3] = -0.014 * min(1.0, self.read_ / 250)
        self.read_ += 1
        return X

    def write(self, wrench):
        self.strongest = max(self.strongest, float(np.linalg.norm(wrench[:3])))


class Left(Sinks):
    """The same for the other hand."""


def scene(**changes):
    return {"objects": [BALL], "operator": FAR, "mapping": {"scale": 1.0}, **changes}


def on(kind):
    return {"leader": {"driver": f"{kind.__module__}:{kind.__name__}"}}


def trusted(values):
    return palpate.Scene.model_validate(values).with_origin("", {}, trust=True)


def test_a_scene_with_a_driver_runs_in_real_time_at_the_rate_of_the_driver():
    session = palpate.Session(trusted(scene(arms=on(Sinks))))
    assert not session.plant.simulated
    assert session.rate == 500.0
    summary = session.run(10.0, on_progress=lambda state: state.force > 1.0 and session.finish())
    assert summary.realtime
    assert summary.peak_force_N == pytest.approx(session.plant.driver.strongest)
    assert 1.0 < summary.peak_force_N <= 3.0
    assert session.state.phase == ""


def test_an_object_that_drives_a_device_takes_the_place_of_the_simulated_arm():
    driver = Sinks()
    assert palpate.Session(scene(), driver=driver).run(0.8).peak_force_N == pytest.approx(driver.strongest)


@pytest.mark.parametrize(
    "act",
    [
        lambda s: s.step(),
        lambda s: s.run(0.1, realtime=False),
        lambda s: s.lead(2, np.zeros((2, 3))),
        lambda s: s.exchange_tool("psm_prograsp"),
        lambda s: s.simulation,
    ],
    ids=["step", "lockstep", "lead", "tool", "simulation"],
)
def test_what_needs_a_time_of_its_own_is_refused_on_a_device_and_moves_nothing(act):
    session = palpate.Session(scene(), driver=(driver := Sinks()))
    with pytest.raises(StateError, match="has a time of its own"):
        act(session)
    assert driver.read_ == 0


def test_a_missing_driver_is_named_with_its_place(tmp_path):
    file = tmp_path / "scene.yaml"
    file.write_text("objects: [{name: ball, sphere: {radius: 0.03}}]\narms: {leader: {driver: no_such:Device}}\n")
    with pytest.raises(DeviceError, match="no_such"):
        palpate.Session(palpate.Scene.load(file, trust=True))


def two(right, left):
    hands = {"right": {"operator": FAR}, "left": {"operator": {"path": [
        {"t": t, "xyz": [-0.1, 0.0, 0.04]} for t in (0.0, 1.0)]}}}  # fmt: skip
    for name, kind in (("right", right), ("left", left)):
        if kind is not None:
            hands[name]["arms"] = on(kind)
    return trusted({"objects": [BALL], "mapping": {"scale": 1.0}, "pairs": hands})


def test_a_device_and_a_simulated_hand_are_one_session():
    session = palpate.PairsSession(two(Sinks, None))
    assert session.driven
    summary = session.run(10.0, on_progress=lambda states: states["right"].force > 1.0 and session.interrupt())
    assert summary.pairs["right"].peak_force_N > 1.0
    assert summary.pairs["right"].realtime
    with pytest.raises(StateError, match="pair right is felt on test_plants:Sinks"):
        session.step()
    with pytest.raises(StateError, match="lockstep"):
        session.run(0.1, realtime=False)


def test_two_devices_lead_two_hands_and_one_device_cannot():
    session = palpate.PairsSession(two(Sinks, Left))
    assert [pair.plant.hardware for pair in session.pairs.values()] == [("test_plants:Sinks",), ("test_plants:Left",)]
    found = session.run(0.5)
    assert all(pair.realtime and pair.ticks > 0 for pair in found.pairs.values())
    assert all(pair.plant.driver.read_ > 0 for pair in session.pairs.values())
    with pytest.raises(palpate.PalpateError, match="the pairs right and left both have"):
        palpate.PairsSession(two(Sinks, Sinks))


def test_a_scene_with_pairs_names_the_session_that_takes_it():
    with pytest.raises(palpate.PalpateError, match=r"palpate\.PairsSession"):
        palpate.Session("two_hands")


def test_a_rig_that_does_not_know_the_device_is_refused():
    rig = build(palpate.Scene.model_validate(scene()))
    with pytest.raises(StateError, match="the rig of a device is built by its session"):
        palpate.Session(scene(), rig=rig, driver=(driver := Sinks()))
    assert driver.read_ == 0
