"""Scenes of many objects: those that the tool cannot have reached are left out, and no bit of a run changes."""

import numpy as np
import pytest

from palpate import _core
from palpate.record.ticks import SIGNALS, as_ticks
from palpate.scene import Scene, rig
from palpate.scene.contact_method import loaded
from palpate.world.mesh.files import write
from palpate.world.shapes.analytic import SHAPES

SIDE, STEP = 5, 0.012


def beads(method, folder):
    """A lattice of balls, boxes and meshes around the origin, one of them moving, and a hand that moves among them."""
    vertices, triangles = SHAPES["sphere"].mesh(1000)
    write(folder / "ball.stl", 4.0 * vertices / np.linalg.norm(vertices, axis=1).max(), triangles)
    kinds = (
        {"sphere": {"radius": 0.004}},
        {"box": {"size": [0.006, 0.006, 0.006]}},
        {"mesh": str(folder / "ball.stl"), "unit": "mm"},
    )
    k = np.arange(SIDE**2)
    at = STEP * (np.stack([k % SIDE, k // SIDE], axis=1) - 0.5 * (SIDE - 1))
    objects = [
        {
            "name": f"bead{i}",
            **kinds[i // 6 % 3],
            "pose": {"xyz": [*p, -0.01 * (i % 2)]},
            "stiffness": 300,
            "friction": 0.1,
        }
        for i, p in enumerate(at.tolist())
    ]
    objects[3]["motion"] = {"amplitude": [0, 0, 0.004], "period": 0.5}
    way = [
        [-0.03, -0.03, 0.02],
        [-0.02, -0.02, 0.001],
        [0.025, 0.02, 0.0],
        [0.03, -0.02, 0.03],
        [-0.01, 0.0, -0.004],
        [0.0, 0.0, 0.08],
    ]
    path = [{"t": 0.4 * i, "xyz": p} for i, p in enumerate(way)]
    return Scene.model_validate({
        "objects": objects,
        "contact": {"method": method},
        "arms": {"follower": {"start": {"xyz": way[0], "rpy_deg": [180, 0, 0]}}},
        "mapping": {"scale": 1.0},
        "operator": {"path": path},
    })  # fmt: skip


@pytest.mark.parametrize("method", ["proxy", "penalty"])
def test_objects_that_are_left_out_change_no_bit(method, tmp_path):
    """Setting the scene anew in each tick makes every object due in each tick: the oracle without a broad phase."""
    made = rig.build(beads(method, tmp_path))
    quick, thorough = made.simulation(), made.simulation()
    rows = np.array(quick.run(2000))
    all_due = []
    for _ in range(2000):
        thorough.set_snapshot(made.snapshot)
        all_due.append(np.array(thorough.run(1)))
    ticks = as_ticks(rows)
    touched = set(ticks["touch_object"][ticks["contacts"] > 0, 0].astype(int).tolist())
    assert {one // 6 % 3 for one in touched} == {0, 1, 2}, "the tool meets balls, boxes and meshes"
    others = as_ticks(np.concatenate(all_due))
    for name, signal in SIGNALS.items():
        if signal.deterministic:
            assert ticks[name].tobytes() == others[name].tobytes(), name


def test_a_scene_of_64_objects_runs_and_a_running_loop_refuses_more_than_it_has_room_for():
    at = 0.02 * np.stack([np.arange(64) % 8, np.arange(64) // 8, np.zeros(64)], axis=1)
    scene = {
        "objects": [
            {"name": f"b{i}", "sphere": {"radius": 0.005}, "pose": {"xyz": p}} for i, p in enumerate(at.tolist())
        ]
    }
    made = rig.build(Scene.model_validate(scene))
    simulation = made.simulation()
    assert np.isfinite(np.array(simulation.run(50))[:, 0]).all()
    small = rig.build(Scene.model_validate({"objects": scene["objects"][:1]})).simulation()
    with pytest.raises(ValueError, match="64 objects, and this loop was made for at most 32"):
        small.set_snapshot(made.snapshot)


def test_the_paper_s_methods_take_32_meshes():
    mesh = _core.Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    many = _core.Snapshot(
        [_core.Object(f"m{i}", mesh, np.eye(4), _core.Material(np.full(3, 300.0))) for i in range(33)]
    )
    with pytest.raises(ValueError, match="take at most 32 objects, and the scene has 33"):
        _core.contact_check(loaded("paper-plane"), _core.ContactOptions(), many)
