"""A device across a network: its hand feels what the far instrument has learnt, and nothing without a link."""

import threading
import warnings

import numpy as np
import pytest

from palpate import _network
from palpate.devices import DrivenSession
from palpate.record import Record
from palpate.scene import Scene
from palpate.scene.rig import build

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
        return DrivenSession(scene(), out, driver=Presses())


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
