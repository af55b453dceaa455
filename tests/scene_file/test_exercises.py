"""Exercises of the dVRK's simulators load as scenes; what they cannot hold is refused by name."""

from __future__ import annotations

import json

import numpy as np
import pytest

from palpate.base.errors import SceneError
from palpate.cli import main
from palpate.scene import Scene

BOARD = """<?xml version="1.0"?>
<robot name="board">
  <material name="grey"><color rgba="0.8 0.8 0.8 1"/></material>
  <link name="board">
    <inertial><mass value="1.0"/></inertial>
    <visual><geometry><box size="0.1 0.08 0.005"/></geometry><material name="grey"/></visual>
    <collision><origin xyz="0 0 -0.0025" rpy="0 0 0"/><geometry><box size="0.1 0.08 0.005"/></geometry></collision>
    <visual><geometry><cylinder radius="0.002" length="0.02"/></geometry>
      <material name="blue"><color rgba="0.2 0.4 0.7 1"/></material></visual>
    <collision><origin xyz="0.02 0 0.01"/><geometry><cylinder radius="0.002" length="0.02"/></geometry></collision>
    <contact><lateral_friction value="0.3"/></contact>
  </link>
</robot>
"""
RING = """<robot name="ring"><link name="ring">
  <inertial><mass value="0.005"/></inertial>
  <collision><geometry><mesh filename="meshes/ring.obj"/></geometry></collision>
</link></robot>
"""
EXERCISE = """scene:
  name: pegs
  objects:
  - {name: peg_board, asset: package://their_simulator/share/assets/board.urdf, fixed: true, position: [0, 0, 0.035]}
  - {name: ring, asset: package://their_simulator/share/assets/ring.urdf, fixed: false, position: [0.02, 0, 0.050],
     orientation_xyzw: [0, 0, 0.3826834323650898, 0.9238795325112867]}
"""


def ring_of_blocks(inner=0.005, outer=0.008, height=0.003, pieces=8):
    """An OBJ of convex pieces around a hole, as a convex decomposition has it."""
    lines, count = [], 0
    for k in range(pieces):
        a = 2.0 * np.pi * (np.array([k, k + 1]) + np.array([0.01, -0.01])) / pieces
        corners = [
            (r * np.cos(t), r * np.sin(t), z) for z in (-height / 2, height / 2) for r in (inner, outer) for t in a
        ]
        lines += [f"o convex_{k}", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in corners)]
        for quad in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            i = [count + 1 + q for q in quad]
            lines += [f"f {i[0]} {i[1]} {i[2]}", f"f {i[0]} {i[2]} {i[3]}"]
        count += 8
    return "\n".join(lines) + "\n"


@pytest.fixture
def exercise(tmp_path):
    """The file of an exercise in a package that was unpacked under another name."""
    folder = tmp_path / "their_simulator-main" / "share"
    (folder / "assets" / "meshes").mkdir(parents=True)
    (folder / "exercises").mkdir()
    (folder / "assets" / "board.urdf").write_text(BOARD)
    (folder / "assets" / "ring.urdf").write_text(RING)
    (folder / "assets" / "meshes" / "ring.obj").write_text(ring_of_blocks())
    file = folder / "exercises" / "pegs.yaml"
    file.write_text(EXERCISE)
    return file


def test_objects_become_bodies_with_their_shapes_masses_and_poses(exercise):
    board, ring = Scene.load(exercise).bodies
    assert (board.name, board.fixed, board.friction) == ("peg_board", True, 0.3)
    assert board.parts[0].box == pytest.approx((0.1, 0.08, 0.005))
    assert board.parts[1].cylinder.radius == pytest.approx(0.002)
    assert board.parts[1].pose.xyz == pytest.approx((0.02, 0.0, 0.01))
    assert board.parts[1].color == (51, 102, 178)
    assert (ring.mass, ring.fixed) == (0.005, False)
    assert ring.pose.rpy_deg == pytest.approx((0.0, 0.0, 45.0))


def test_a_ring_falls_around_its_peg_and_not_onto_it(exercise, tmp_path):
    pytest.importorskip("mujoco")
    out = tmp_path / "out.json"
    folder = str(tmp_path / "runs")
    assert main(["run", str(exercise), "--headless", "--duration", "0.5", "--out", folder, "--json", str(out)]) == 0
    from palpate import Record

    places = Record.open(json.loads(out.read_text())["record"]).bodies
    p = places.at(0.5)["ring"][:3]
    assert np.hypot(p[0] - 0.02, p[1]) < 0.004, "the peg stands in the hole"
    assert p[2] == pytest.approx(0.035 + 0.0015, abs=5e-4), "the ring lies on the board"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("board.urdf", "no.urdf"), r"object 1 \(peg_board\): .*assets/no.urdf of the exercise is not found"),
        (("position: [0, 0, 0.035]", "position: [0, 0]"), "the pose of an object is invalid"),
        (("asset: package://their_simulator/share/assets/board.urdf, ", ""), "object 1: an object of the .* no asset"),
    ],
)  # fmt: skip
def test_files_that_are_wrong_are_named(exercise, change, words):
    exercise.write_text(EXERCISE.replace(*change))
    with pytest.raises(SceneError, match=words):
        Scene.load(exercise)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('size="0.1 0.08 0.005"/></geometry></coll', 'size="0.1 x 5"/></geometry></coll', "box size='0.1 x 5'> of"),
        ("</robot>", '<link name="two"/></robot>', "has 2 links"),
        ("</robot>", "", "cannot be read"),
        ("<robot", '<!DOCTYPE a [<!ENTITY b "c">]><robot', "it declares entities"),
    ],
)  # fmt: skip
def test_assets_that_are_wrong_are_named(exercise, old, new, words):
    (exercise.parent.parent / "assets" / "board.urdf").write_text(BOARD.replace(old, new))
    with pytest.raises(SceneError, match=words):
        Scene.load(exercise)
