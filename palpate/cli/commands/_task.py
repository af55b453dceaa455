"""The task of a scene in `palpate run`: its place by the seed, its operator, and its result."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.scene import Scene
    from palpate.session import PairsSession, Session
    from palpate.session.tasks import TaskRun


def drawn(scene: Scene, seed: int | None) -> Scene:
    """The scene with what its task leaves to the seed; the scene itself without a task."""
    if scene.task is None:
        return scene
    from palpate.session import tasks

    return tasks.drawn(scene, scene.seed if seed is None else seed)


def task_of(session: Session | PairsSession) -> TaskRun | None:
    """The task of a session's scene, judged and operated from now on; None without one."""
    if session.scene.task is None:
        return None
    from palpate.session.tasks import TaskRun

    return TaskRun(session)


def with_result(summary: object, task: TaskRun | None, console: Console) -> object:
    """What `--json` writes: the summary, with the result of the task beside it, null without one; prints the result."""
    from palpate.base.arrays.plain import plain
    from palpate.cli.terminal.output import say

    values = plain(summary)
    assert isinstance(values, dict)
    if task is None:
        return values | dict.fromkeys((*_KEYS, "task"))
    found = task.result
    say(console, f"{found.progress}: score {found.score:.1f}, {found.drops} drops, {found.time_s:.1f} s", "task:")
    result = plain(found)
    assert isinstance(result, dict)
    return values | {key: result[key] for key in _KEYS} | {"task": result["errors"]}


_KEYS = ("success", "score", "drops", "time_s")
