"""Motion plans: collision-free motions of a whole instrument through its remote centre.

found = palpate.planning.plan("planning", goal="target")
found.success, found.clearance_m, found.duration_s
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from palpate.planning import changing
from palpate.planning.execute import Execution
from palpate.planning.problem import Problem
from palpate.planning.result import Plan, load

if TYPE_CHECKING:
    import os
    from collections.abc import Callable

    from palpate.planning.world import World
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
    world: Callable[[], World] | None = None,
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
        world: returns the present world of a scene that changes meanwhile; the plan is then free in the newest one, or
            has no success and names what comes too near (`palpate.planning.changing`).

    Raises:
        PlanningError: start or goal is invalid or in collision. SceneError: the scene or the arm is invalid.
    """
    from palpate.scene import Scene

    loaded = scene if isinstance(scene, Scene) else Scene.load(scene)
    problem = Problem.of(loaded, arm)
    if world is None:
        return problem.plan(start, goal, clearance, seed, timeout)
    return changing.plan(problem, world, lambda now, left: now.plan(start, goal, clearance, seed, left), timeout)
