"""Two devices press one soft organ: in every tick their forces and the reaction of its ground change its momentum."""

from __future__ import annotations

import numpy as np
import pytest

from palpate import Scene
from palpate.devices.loop import DeviceLoop, device_scene
from palpate.scene.together import build_pairs
from palpate.world.tissue import TetMesh, save
from palpate.world.tissue.blocks import block

pytest.importorskip("meshio", reason="extra tissue")

DT, TICKS, DAMPING = 1e-3, 500, 5.0  # of a tick [s]; their number; of the body, per mass [1/s]
SCENE = """
objects:
  - name: organ
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    pose: {xyz: [0, 0, -0.02]}
    tissue:
      {volume: organ.vtk, young: 12000, poisson: 0.45, prony: [], fixed: [{at: [0, 0, -0.02], box: [1, 1, 0.002]}]}
contact: {radius: 0.004}
mapping: {scale: 1.0}
stability: {passivity: "off", force_cap: 8.0, rate_cap: 7000}
pairs:
  right:
    arms: {leader: {driver: "loop:right"}}
    operator: {path: [{t: 0, xyz: [0.012, 0, 0.006]}, {t: 1, xyz: [0.012, 0, 0.006]}]}
  left:
    arms: {leader: {driver: "loop:left"}}
    operator: {path: [{t: 0, xyz: [-0.012, 0, 0.006]}, {t: 1, xyz: [-0.012, 0, 0.006]}]}
"""


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """Felt forces (2, n, 3) [N] of two devices that tap and rub, displacements (n, m, 3) [m] of the organ, its body."""
    folder = tmp_path_factory.mktemp("organ")
    nodes, tets = block((6, 6, 4), (0.06, 0.06, 0.04))
    save(TetMesh(nodes - [0.03, 0.03, 0.02], tets), folder / "organ.vtk", unit="m")
    (folder / "scene.yaml").write_text(SCENE)
    rigs = build_pairs(Scene.load(folder / "scene.yaml"))
    loops = [DeviceLoop(device_scene(rig.scene, "loop", 1.0 / DT), rig=rig) for rig in rigs.values()]
    organ, felt, shapes = rigs["right"].snapshot.objects[0].surface, np.zeros((2, TICKS, 3)), []
    for loop in loops:
        loop.start()
    for k in range(TICKS):
        for i, loop in enumerate(loops):
            loop.step(1.0 + k * DT, hand(i, k * DT), None, 0.0, 0)
            felt[i, k] = loop.wrench[:3]
        shapes.append(organ.displacements())
    return felt, np.array(shapes), rigs["right"].surfaces[0].body.body


def hand(i, t):
    """Down by 8 mm within 150 ms, tapping at 6 Hz and rubbing at 4 Hz."""
    s = min(1.0, t / 0.15)
    s *= s * (3.0 - 2.0 * s)
    X = np.eye(4)
    X[0, 3] = (1.0, -1.0)[i] * 0.002 * s * np.sin(8.0 * np.pi * t)
    X[2, 3] = -0.008 * s - 0.002 * s * np.sin(12.0 * np.pi * t + i)
    return X


def reactions(u, body):
    """Force of the ground on the organ at each shape (n, 3) [N]: it holds what pulls at the nodes on it."""
    rest, found = body.positions().copy(), []
    ground = rest[:, 2] < rest[:, 2].min() + 1e-6
    for shape in u:
        body.set_state(rest + shape, np.zeros_like(shape))
        found.append(-body.internal_forces()[ground].sum(axis=0))
    body.reset()
    return np.array(found)


def imbalance(forces, u, body, inertia=1.0):
    """Change of the organ's momentum less what hands, ground and damping give it, in each tick (n, 3) [N].

    Between two shapes act the newest force of the first loop, and that of the second one a tick before.
    """
    late = np.stack([forces[0], np.vstack([np.zeros((1, 3)), forces[1, :-1]])]).sum(axis=0)
    momentum = np.einsum("n,kni->ki", body.masses(), np.diff(u, axis=0)) / DT
    hands = -0.5 * (late[1:-1] + late[2:])
    damped = -0.5 * DAMPING * (momentum[1:] + momentum[:-1])
    return inertia * np.diff(momentum, axis=0) / DT - (hands + reactions(u, body)[1:-1] + damped)


def test_the_forces_of_two_hands_are_the_balance_of_the_organ(pressed):
    felt, u, body = pressed
    assert np.linalg.norm(felt, axis=2).max(axis=1).min() > 0.8, "both hands press"
    assert np.linalg.norm(imbalance(felt, u, body), axis=1).max() < 0.004
    assert np.linalg.norm(imbalance(felt, u, body).sum(axis=0)) * DT < 1e-3 * np.linalg.norm(felt, axis=2).sum() * DT


def test_the_balance_finds_a_missing_hand_and_a_missing_momentum(pressed):
    felt, u, body = pressed
    one = felt * np.array([1.0, 0.0])[:, None, None]
    assert np.linalg.norm(imbalance(one, u, body), axis=1).max() > 0.5, "control"
    assert np.linalg.norm(imbalance(felt, u, body, inertia=0.0), axis=1).max() > 0.05, "control"
    assert np.linalg.norm(imbalance(0.98 * felt, u, body), axis=1).max() > 0.02, "control: 2 % too little"
