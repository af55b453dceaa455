"""A device across a network: its hand feels what the far instrument has learnt, and nothing without a link."""

import threading
import time
import warnings

import numpy as np
import pytest

from palpate import _network
from palpate.base.errors import PalpateError
from palpate.record import Record
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import Session

pytest.importorskip("cryptography", reason="links need the extra remote")
from palpate.session.remote import link as links
from palpate.session.remote import site as sites

KEY = bytes(range(32))
K, PLACE = 600.0, -0.001


class Presses:
    """A hand that rests for 2 s, goes down by 9 mm, and then presses by 6 mm more, up and down, once a second."""

    rate, force_max, workspace = 500.0, 3.0, (0.1, 0.1, 0.1)

    def open(self):
        self.count, self.forces = 0, []

    def read(self):
        self.count += 1
        t = self.count / self.rate
        X = np.eye(4)
        X[2, 3] = -0.009 * np.clip(t - 2.0, 0.0, 1.0) - 0.003 * (1.0 - np.cos(2.0 * np.pi * max(t - 3.0, 0.0)))
        return X

    def write(self, wrench):
        self.forces.append((self.count / self.rate, float(np.linalg.norm(wrench))))

    def close(self):
        pass


def scene():
    return Scene.model_validate({
        "objects": [{"name": "table", "plane": {}, "stiffness": 300, "damping": 1}],
        "arms": {"leader": {"driver": "test:Presses"}},
        "mapping": {"scale": 1.0},
        "contact": {"radius": 0.002},
        "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.012]}, {"t": 1.0, "xyz": [0.0, 0.0, 0.012]}]},
        "remote": {"site_shift": [0, 0, PLACE], "site_stiffness": K},
    })  # fmt: skip


@pytest.fixture
def follower():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        server = sites.FollowerServer(build(scene()), KEY, "127.0.0.1", 0, 500.0, str)
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server
    server.stop()
    thread.join()


def driven(out=None):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return Session(scene(), out, driver=Presses())


def test_a_device_feels_what_the_far_instrument_has_learnt(follower, tmp_path):
    session = driven(tmp_path)
    with links.RemoteLink(session, ("127.0.0.1", follower.port), KEY, 500.0) as remote:
        summary = session.run(8.0)
        found = remote.figures()
    (model,) = found["models"]
    assert model["stiffness_N_per_m"] == pytest.approx(K, rel=0.1)
    assert model["shift_m"][2] == pytest.approx(PLACE, abs=3e-4)
    record = Record.open(summary.record)
    late = (record["remote_link"] == 2.0) & (record["t"] > 5.0)
    depth = PLACE + 0.002 - record["p_WT"][late, 2]  # of the tool's sphere below the far surface
    felt, pressed = record["F_T_W"][late, 2], depth > 1e-3
    assert depth.max() > 2e-3
    assert np.median(felt[pressed] / (K * depth[pressed])) == pytest.approx(1.0, abs=0.05)
    assert np.linalg.norm(record["F_H_L"][late], axis=1).max() > 1.0
    assert follower.largest < 3.0


def test_a_device_without_a_link_feels_nothing():
    """The end is attached and no follower is there: the tool holds, and the hand is free."""
    session = driven()
    device = session._loop.driver
    options = _network.LoopEndOptions()
    session.attach(_network.LoopEnd(options, session.rig.snapshot))
    session.run(4.0)
    assert max(force for _, force in device.forces) == 0.0


def test_a_cycle_whose_link_has_gone_feels_no_force_of_it():
    """In mode `direct` the newest force of the far tool is felt; it must not outlive the link."""
    driver, end_options, peer = Presses(), _network.LoopEndOptions(), _network.Peer()
    end_options.mode = _network.Mode.direct
    session = driven()
    cycle, end, felt = session._loop.cycle, _network.LoopEnd(end_options, session.rig.snapshot), np.zeros(6)
    driver.open()

    def steps(n):
        for _ in range(n):
            now, answer = time.monotonic(), _network.Datagram()
            peer.receive(_network.decode(end.packet()), now)
            answer.flags, answer.F = _network.FLAG_ALIGNED, np.array([0.0, 0.0, 1.0])
            peer.stamp(answer, now)
            end.receive(_network.encode(answer), now)
            X = driver.read()
            cycle.step(driver.count / driver.rate, X, None, 0.0, False, felt)
        return float(np.linalg.norm(felt[:3]))

    cycle.attach(end)
    assert steps(400) > 0.5
    cycle.attach(None)
    assert steps(200) == 0.0


def test_a_link_does_not_join_a_session_that_runs():
    session = driven()
    session.start()
    try:
        with pytest.raises(PalpateError, match="runs in real time already"):
            session.attach(None)
    finally:
        session.close()
