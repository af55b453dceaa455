"""The shaft of an instrument among bodies: what is felt does the engine's work, and the hand gets no energy."""

from __future__ import annotations

import numpy as np
import pytest
from test_bodies_energy import ALLOWANCE, LEADERS, MTM, scene_of

pytest.importorskip("mujoco")

import mujoco

from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.session import Session

RCM = 0.19  # height of the remote centre over the origin [m]
POST = {"name": "post", "parts": [{"box": [0.01, 0.06, 0.02]}], "friction": 0.2}


def beside_a_post(height, aside, path, **stability):
    """A PSM, moved along a path, with a fixed post on its right."""
    post = POST | {"fixed": True, "pose": {"xyz": [aside + 0.005, 0, height]}}
    return Scene.model_validate({
        "objects": [{"name": "table", "plane": {"size": 0.2}, "pose": {"xyz": [0, 0, -0.1]}}], "bodies": [post],
        "arms": {"leader": MTM, "follower": {"model": "psm_prograsp", "base": {"xyz": [0, 0, RCM]}}},
        "mapping": {"scale": 1.0, "align_rate": 0}, "operator": {"path": path, "hand": "firm"},
        "stability": {"friction_share": 0.0} | stability,
    })  # fmt: skip


def on_shaft(session):
    """Force of the engine's contacts on the virtual shaft (3,), and their mean position (3,), in W."""
    model, data = session.world.model, session.world.data
    shaft, F, p, wrench = int(model.geom("tool/shaft").id), np.zeros(3), [], np.zeros(6)
    for i in range(data.ncon):
        contact = data.contact[i]
        if shaft in contact.geom:
            mujoco.mj_contactForce(model, data, i, wrench)
            F += (1.0 if contact.geom[1] == shaft else -1.0) * contact.frame.reshape(3, 3).T @ wrench[:3]
            p.append(contact.pos)
    return F, np.mean(p, axis=0) if p else np.full(3, np.nan)


def point_motion(rig, q, p):
    """How the point p (3,) of the shaft moves with the tip whose orientation is kept (3, 3), by inverse kinematics."""
    follower, X_WB = rig.arms.follower, rig.arms.X_WB
    X_BT, step = follower.fk(q), 1e-5

    def shaft(joints):
        return X_WB @ follower.link_poses(joints, 0.0)["shaft"]

    at = np.linalg.solve(shaft(q), [*p, 1.0])
    columns = []
    for axis in np.eye(3):
        ends = []
        for sign in (-1.0, 1.0):
            goal = X_BT.copy()
            goal[:3, 3] += sign * step * X_WB[:3, :3].T @ axis
            ends.append(shaft(follower.ik(goal, q)) @ at)
        columns.append((ends[1] - ends[0])[:3] / (2.0 * step))
    return np.transpose(columns)


@pytest.mark.parametrize("height", [0.075, 0.105])
def test_a_push_on_the_shaft_is_felt_by_the_work_that_it_does(height):
    """Virtual work by a second way: the engine's contact force on the motion that inverse kinematics finds."""
    path = [{"t": 0.0, "xyz": [0, 0, 0.03]}, {"t": 1.0, "xyz": [0.03, 0, 0.03]}, {"t": 4.0, "xyz": [0.03, 0, 0.03]}]
    session = Session(beside_a_post(height, 0.008, path, force_cap=8.0))
    ticks = as_ticks(session.simulation.run(3500))
    F, p = on_shaft(session)
    felt = ticks["F_instrument_W"][-200:].mean(axis=0)
    moves = point_motion(session.rig, ticks["q_follower"][-1][: session.rig.arms.follower.n], p)
    assert F[0] < -0.5, "the post pushes back"
    assert np.linalg.norm(felt - moves.T @ F) < 0.02 * np.linalg.norm(felt)  # the coupling gives way by 13 mm
    assert abs(felt[0]) < 0.85 * abs(F[0]), "a lever, not the force itself"


def random_push(leader, mass, rng, **stability):
    """The scene of random motions, with a body beside the shaft above the tip."""
    scene = scene_of(leader, mass, rng, **stability)
    post = POST | {"pose": {"xyz": [0.012, 0, 0.1]}} | ({"fixed": True} if mass is None else {"mass": mass})
    floor = {"name": "shelf", "fixed": True, "parts": [{"box": [0.03, 0.1, 0.01]}], "pose": {"xyz": [0.022, 0, 0.085]}}
    bodies = [*scene.model_dump(mode="json", exclude_unset=True)["bodies"], post, floor]
    return Scene.model_validate(scene.model_dump(mode="json", exclude_unset=True) | {"bodies": bodies})


def least_energy(scene, seed):
    """The least energy that a hand has put in [J], and the largest force on the shaft [N]."""
    session, least, most = Session(scene, seed=seed), 0.0, 0.0
    for _ in range(120):
        least = min(least, float(as_ticks(session.simulation.run(20))["energy_port"].min()))
        most = max(most, float(np.linalg.norm(on_shaft(session)[0])))
    return least, most


@pytest.mark.parametrize("leader", LEADERS)
@pytest.mark.parametrize("mass", [0.001, 0.05, None])
def test_random_motions_with_the_shaft_on_a_body_give_the_hand_no_energy(leader, mass):
    alone = {"passivity": "off", "force_cap": 20.0, "rate_cap": 15000.0}
    for k, stability in enumerate(({}, alone)):
        rng = np.random.default_rng([k, 17, list(LEADERS).index(leader)])
        least, most = least_energy(random_push(LEADERS[leader], mass, rng, **stability), k)
        assert least >= -1.02 * ALLOWANCE
        if mass is None:
            assert most > 0.2, "the shaft pressed the post"
