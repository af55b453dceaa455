"""The obstacles of a problem as a `moveit_msgs/PlanningScene`, as the mapping that `ros2 topic pub` takes.

ros2 topic pub --once /planning_scene moveit_msgs/msg/PlanningScene "$(cat planning_scene.yaml)"
"""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import quaternions
from palpate.planning.problem import Problem
from palpate.planning.world import Obstacle

FRAME = "world"
_BOX, _SPHERE, _CYLINDER = 1, 2, 3  # values of shape_msgs/SolidPrimitive.type
_ADD = 0  # value of moveit_msgs/CollisionObject.operation


def planning_scene(problem: Problem) -> dict[str, Any]:
    """The world of a problem as the difference to an empty scene; lengths in m, poses in the frame `world`."""
    objects = [_collision_object(one) for one in problem.world.obstacles]
    model = problem.robot.arm.name
    return {"name": "palpate", "robot_model_name": model, "world": {"collision_objects": objects}, "is_diff": True}


def _collision_object(obstacle: Obstacle) -> dict[str, Any]:
    kind, size, pose = obstacle.solid.kind, np.ptp(obstacle.solid.bounds, axis=0).tolist(), _pose(obstacle.X_WO)
    made: dict[str, Any] = {"header": {"frame_id": FRAME}, "id": obstacle.name, "operation": _ADD}
    solids = {
        "box": (_BOX, size), "sphere": (_SPHERE, [0.5 * size[0]]), "cylinder": (_CYLINDER, [size[2], 0.5 * size[0]]),
    }  # fmt: skip
    if kind in solids:
        number, dimensions = solids[kind]
        return made | {"primitives": [{"type": number, "dimensions": dimensions}], "primitive_poses": [pose]}
    if kind == "half-space":
        return made | {"planes": [{"coef": [0.0, 0.0, 1.0, 0.0]}], "plane_poses": [pose]}
    vertices, triangles = triangles_of(obstacle)
    mesh = {
        "triangles": [{"vertex_indices": [int(i) for i in row]} for row in triangles],
        "vertices": [_point(row) for row in vertices],
    }
    return made | {"meshes": [mesh], "mesh_poses": [pose]}


def _point(p: Array) -> dict[str, float]:
    return {axis: float(value) for axis, value in zip("xyz", p, strict=True)}


def _pose(X: Array) -> dict[str, Any]:
    w, x, y, z = (float(value) for value in quaternions(X[None, :3, :3], canonical=True)[0])
    return {"position": _point(X[:3, 3]), "orientation": {"x": x, "y": y, "z": z, "w": w}}


def triangles_of(obstacle: Obstacle) -> tuple[Array, Any]:
    """Vertices and triangles of a mesh, or of a capsule, which MoveIt does not have."""
    shape = obstacle.solid.coal
    if hasattr(shape, "vertices"):
        count = shape.num_tris
        return np.asarray(shape.vertices()), np.array(
            [[shape.tri_indices(i)[j] for j in range(3)] for i in range(count)]
        )
    import trimesh

    if hasattr(shape, "halfLength"):
        made = trimesh.creation.capsule(2.0 * shape.halfLength, shape.radius, count=[16, 16])
        made.apply_translation(-0.5 * (made.bounds[0] + made.bounds[1]))
    else:
        made = trimesh.creation.icosphere(2, shape.radius)
    return np.asarray(made.vertices), np.asarray(made.faces)
