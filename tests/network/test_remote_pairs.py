"""Several pairs over one link: each hand feels what its own instrument has learnt, and a packet has all states."""

import threading
import warnings

import pytest

from palpate import _network
from palpate.base.errors import PalpateError
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.scene.together import build_pairs
from palpate.session import PairsSession, Session

pytest.importorskip("cryptography", reason="links need the extra remote")
from palpate.cli.commands._remote import require
from palpate.session.network import channel as channels
from palpate.session.remote import link as links
from palpate.session.remote import site as sites

KEY = bytes(range(32))


def arms(side):
    x, turn = {"right": (1.0, -20.0), "left": (-1.0, 20.0)}[side]
    foot = {"right": [0.06, -0.06, 0.155], "left": [-0.12, -0.06, 0.155]}[side]
    yaw = {"right": 155.0, "left": 205.0}[side]
    return {"leader": {"model": f"mtm_{side}", "base": {"xyz": [0.345 * x, 0.243, 0.219], "rpy_deg": [0, 0, turn]}},
            "follower": {"model": "psm_lnd", "base": {"xyz": foot, "rpy_deg": [0, 0, yaw]}}}  # fmt: skip


def operator(x):
    return {"palpate": {"object": "table", "at": [x, 0, 0.1], "force": 1.0, "length": 0.005}}


@pytest.fixture(scope="module")
def scene():
    return Scene.model_validate({
        "objects": [{"name": "table", "plane": {}, "stiffness": 300, "damping": 1}],
        "pairs": {"right": {"arms": arms("right"), "operator": operator(0.03)},
                  "left": {"arms": arms("left"), "operator": operator(-0.03)}},
        "remote": {"site_shift": [0, 0, -0.0015], "site_stiffness": 450, "rate": 500.0},
    })  # fmt: skip


@pytest.fixture
def follower(scene):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        server = sites.FollowerServer(build_pairs(scene), KEY, "127.0.0.1", 0, 500.0, lambda line: None)
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server
    server.stop()
    thread.join()


def session(scene):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return PairsSession(scene)


def test_each_hand_feels_what_its_instrument_has_learnt(scene, follower):
    mine = session(scene)
    with links.RemoteLink(mine, ("127.0.0.1", follower.port), KEY, 500.0) as remote:
        summary = mine.run(6.0, realtime=True)
    assert len(follower.followers) == 2
    for name in ("right", "left"):
        found = remote.figures(name)
        (model,) = found["models"]
        assert model["stiffness_N_per_m"] == pytest.approx(450.0, rel=0.1), name
        assert model["shift_m"][2] == pytest.approx(-0.0015, abs=3e-4)
        assert found["received"] > 500
        assert found["refused"] == 0
        assert 0.3 < summary.pairs[name].peak_force_N < 3.0
        assert name in remote.words(name)
    assert follower.largest < 3.0


def test_a_packet_has_the_states_of_all_pairs():
    one = _network.encode(_network.Datagram())
    assert sites.parts(one * 3, 3) == [one] * 3
    for wrong in (b"", one, one * 2 + one[:-1], one * 4):
        assert sites.parts(wrong, 3) is None
    assert channels.size(3) == channels.size(1) + 2 * len(one)


def test_one_pair_does_not_join_the_follower_of_two(scene, follower):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        alone = build(next(iter(scene.each_pair().values())))
    with pytest.raises(PalpateError, match="another scene"):
        links.RemoteLink(Session(alone.scene, rig=alone), ("127.0.0.1", follower.port), KEY)


def test_pairs_are_no_reason_to_refuse(scene):
    require(scene, None, False)
