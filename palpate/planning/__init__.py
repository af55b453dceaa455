"""Motion plans: collision-free motions of a whole instrument through its remote centre (docs/planning.md).

found = palpate.planning.plan("planning", goal="target")
found.success, found.clearance_m, found.duration_s
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from palpate.planning.execute import Execution
from palpate.planning.problem import Problem
from palpate.planning.result import Plan, load

if TYPE_CHECKING:
    import os

    from palpate.scene import Scene

__all__ = ["Execution", "Plan", "Problem", "load", "plan"]


def plan(
    scene: Scene | str | os.PathLike[str],
    arm: str | None = None,
    start: Any = "current",
    goal: Any = "home",
    clearance: float | None = None,
    seed: int = 0,
    timeout: float = 5.0,
) -> Plan:
    """A motion of the scene's instrument that keeps clear of everything.

    Args:
        scene: the scene, or its file or name.
        arm: name of the arm; the scene's `planning.arm` when left out.
        start: joint positions (n,) [rad, m], X_WT (4, 4), a name (current, home, or of `planning.states`), or a file.
        goal: the same.
        clearance: smallest distance from all objects [m]; the scene's when left out.
        seed: seed of the search; the same seed gives the same plan.
        timeout: time after which the search gives up [s].

    Raises:
        PlanningError: start or goal is invalid or in collision. SceneError: the scene or the arm is invalid.
    """
    from palpate.scene import Scene

    loaded = scene if isinstance(scene, Scene) else Scene.load(scene)
    return Problem.of(loaded, arm).plan(start, goal, clearance, seed, timeout)
