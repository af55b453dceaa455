"""What the tool touches where the scene has no object: a plane is learnt, felt true, passive and without a kick."""

from dataclasses import replace

import numpy as np
import pytest

from palpate import _core, _network
from palpate.base.errors import SceneError
from palpate.record.reader import Record
from palpate.scene import Scene
from palpate.session import Session
from palpate.session.network import network
from palpate.session.remote.emulated import emulate
from palpate.session.remote.site import digest
from palpate_lab.studies.network import work
from palpate_lab.studies.network.worlds import World, options

RADIUS = 0.002  # of the tool [m]


def hidden(seed, change=lambda o: None):
    """The random run of this seed whose world is hidden from both ends."""
    link, world, motion = work.draw(seed)
    o = options("model", motion.hand, link.round_trip, seed, hidden=True)
    o.to_site, o.to_operator = link.to_site, link.to_operator
    change(o)
    world = replace(world, hidden=True)
    return _network.trial(o, world.snapshot(True), world.snapshot(False), motion.path(world, link.round_trip))[0]


def passive(r):
    return min(r.energy_hand, r.energy_site) >= -0.5e-3 and r.kick <= 0.1 and r.force_site <= 3.0


@pytest.mark.parametrize("runs", [24, pytest.param(400, marks=pytest.mark.long)])
def test_hidden_worlds_are_felt_true_and_passive(runs):
    found = [hidden(seed) for seed in range(runs)]
    assert all(passive(r) for r in found)
    assert np.median([r.felt_over_true for r in found]) == pytest.approx(1.0, abs=0.02)
    assert np.mean([0.95 <= r.felt_over_true <= 1.05 for r in found]) >= 0.9
    assert np.median([r.force_rms for r in found]) <= 0.05
    assert max(r.drift for r in found) <= 1e-4


def test_updates_without_the_tank_are_not_passive():
    """The judge refuses a plane that appears under a hand that has put in no energy."""

    def planted(o):
        ends = o.operator_end
        update = ends.update
        update.tank = update.capacity = 1e3
        update.force_rate = 1e6
        ends.update = update
        o.operator_end = ends

    assert any(not passive(hidden(seed, planted)) for seed in range(4))


def test_a_hidden_world_without_planes_is_not_felt():
    def planted(o):
        ends, site = o.operator_end, o.site
        ends.planes = site.planes = False
        o.operator_end, o.site = ends, site

    with pytest.raises(ValueError, match=r"trial\.model"):
        hidden(0, planted)


def felt(spoil=lambda m: None, update=None, seconds=6.0, seed=0):
    """A hand that presses a tilted plane which the operator's end learns late: by numpy, from the pose of the model.

    Returns the slope of the felt over the true force from the second press on, the lowest energy that the hand has
    put in [J], and the largest change of the force by an update in a tick [N].
    """
    rng = np.random.default_rng(seed)
    n = np.array([*rng.uniform(-0.3, 0.3, 2), 1.0])
    n /= np.linalg.norm(n)
    K, model = 500.0, _network.LocalModel(update or _network.UpdateOptions(), _core.Snapshot([]), planes=True)
    m = _network.ModelEstimate()
    m.object, m.K, m.sd_K, m.shift, m.normal = 0, K, 1.0, np.zeros(3), n
    spoil(m)

    def force(p):
        plane = model.scene.objects[0]
        depth = RADIUS - plane.X_WO[:3, 2] @ (p - plane.X_WO[:3, 3])
        return plane.material.K[0] * max(depth, 0.0) * plane.X_WO[:3, 2]

    p, F, energy, lowest, kick, pairs = np.array([0.0, 0.0, 0.01]), np.zeros(3), 0.0, 0.0, 0.0, []
    for k in range(int(1e3 * seconds)):
        if k == 400:
            model.take(m)
        before = force(p)
        model.step(p, np.zeros(3), F, RADIUS, 1e-3 * k, 1e-3)
        F = force(p)
        kick = max(kick, np.linalg.norm(F - before))
        if k > 1500:
            pairs.append((F, K * max(RADIUS - n @ p, 0.0) * n))
        nearer = np.array([2e-3 * np.sin(k / 300), 0.0, 0.002 + 0.004 * np.cos(2 * np.pi * 1e-3 * k)])
        energy -= 0.5 * (F + force(nearer)) @ (nearer - p)
        lowest, p = min(lowest, energy), nearer
    both = np.array(pairs)
    return np.sum(both[:, 0] * both[:, 1]) / np.sum(both[:, 1] ** 2), lowest, kick


def test_a_plane_that_is_learnt_under_the_hand_is_felt_without_kick_and_free_energy():
    for seed in range(5):
        slope, lowest, kick = felt(seed=seed)
        assert slope == pytest.approx(1.0, abs=0.02)
        assert lowest >= -0.2e-3 - 1e-6  # the first content of the tank
        assert kick <= 0.02 + 1e-6  # 20 N/s


def test_a_reversed_normal_and_a_missing_tank_are_found():
    def reversed_(m):
        m.normal = -m.normal

    assert not felt(reversed_)[0] > 0.5
    limitless = _network.UpdateOptions()
    limitless.tank = limitless.capacity = limitless.force_rate = limitless.speed = 1e3
    _, lowest, kick = felt(update=limitless)
    assert lowest < -0.5e-3
    assert kick > 0.04  # twice what 20 N/s allow


def scene(**remote):
    return Scene.model_validate({
        "objects": [{"name": "table", "plane": {}, "stiffness": 400, "damping": 1}],
        "arms": {"leader": {"model": "mtm_right", "base": {"xyz": [0.345, 0.243, 0.219], "rpy_deg": [0, 0, -20]}},
                 "follower": {"model": "psm_lnd", "base": {"xyz": [-0.12, -0.06, 0.155], "rpy_deg": [0, 0, 205]}}},
        "operator": {"palpate": {"object": "table", "at": [0, 0, 0.1], "force": 1.2, "length": 0.01}},
        "remote": {"planes": True, "hidden": ["table"], **remote},
    })  # fmt: skip


def test_a_session_feels_a_hidden_object_across_an_emulated_network(tmp_path):
    mine = Session(scene(), out=tmp_path)
    emulate(mine, network("netfi-delay-1"), 1)
    record = Record.open(mine.run(10.0).record)
    late = record["t"] > 6.0
    model, measured = (np.linalg.norm(record[name][late], axis=1) for name in ("F_T_W", "F_remote_W"))
    touched = record["touch_object"][late & (record["contacts"] > 0), 0]
    assert set(touched.astype(int)) == {1}  # the plane; 0 is the hidden table
    assert np.quantile(model, 0.9) == pytest.approx(np.quantile(measured, 0.9), rel=0.1)
    assert np.quantile(model, 0.9) > 0.4


def test_wrong_planes_and_names_are_told():
    for remote, words in (
        ({"hidden": ["tabel"]}, r"remote\.hidden: no object is named 'tabel'"),
        ({"mode": "direct"}, r"remote\.planes: the mode direct has no model"),
    ):
        with pytest.raises(SceneError, match=words):
            emulate(Session(scene(**remote)), network("none"))


def test_ends_must_agree_about_planes_and_hidden_objects():
    here = digest({"": scene()})
    assert digest({"": scene(planes=False)}) != here
    assert digest({"": scene(hidden=[])}) != here


def test_planes_have_unit_normals():
    d = _network.Datagram()
    m = d.model
    m.normal = np.array([0.0, 0.6, 0.8])
    d.model = m
    np.testing.assert_allclose(_network.decode(_network.encode(d)).model.normal, m.normal, atol=1e-7)
    m.normal = np.array([0.0, 0.0, 0.5])
    d.model = m
    assert _network.decode(_network.encode(d)) is None


def test_a_known_object_is_learnt_although_planes_are_felt():
    """A touch that a known surface explains begins no plane."""
    o = options("model", "normal", 0.05, 1, hidden=True)
    world = World()
    path = work.Motion().path(world, 0.05)
    r, rows = _network.trial(o, world.snapshot(True), world.snapshot(False), path)
    K = rows[-1, _network.trial_columns().index("K")]  # of the known object, the first
    assert pytest.approx(world.K, rel=0.03) == K
    assert r.felt_over_true == pytest.approx(1.0, abs=0.05)
