"""The viewer during an attended session: the next place to touch, and the ellipsoids of the targets."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.cli.terminal import HOST
from palpate.cli.terminal.output import say
from palpate.cli.terminal.view import free_port, require_viewer

if TYPE_CHECKING:
    from palpate.cli.commands.register._attended import Dialogue, Pointer
    from palpate.record.ticks import Ticks
    from palpate.viewer.stage import PlacedFrame, TargetMark


@contextmanager
def shown(console: Console, pointer: Pointer, dialogue: Dialogue, port: int) -> Iterator[None]:
    """Serves the viewer of the arm's session while the context is open.

    Raises:
        PalpateError: the pointer is a tracked tool, which has no session. PortError: the port cannot be used.
    """
    from palpate.cli.commands.register._attended import ArmPointer

    if not isinstance(pointer, ArmPointer):
        raise PalpateError("the viewer shows the arm, and the pointer is a tracked tool", mend="leave out --viewer")
    require_viewer()
    from palpate.viewer import LiveViewer, stage_of

    stage = stage_of(pointer.session.rig)
    stage = replace(stage, targets=marks(dialogue, stage.targets), frames=(*stage.frames, _next(dialogue)))
    viewer = LiveViewer(pointer.session, stage, HOST, free_port(port))
    say(console, f"viewer: {viewer.url}")
    try:
        yield
    finally:
        viewer.close()


def marks(dialogue: Dialogue, targets: tuple[TargetMark, ...]) -> tuple[TargetMark, ...]:
    """The targets with the newest prediction of the dialogue's procedure."""

    def newest(mark: TargetMark) -> tuple[Array, Array]:
        state = dialogue.procedure
        if state is None:
            return mark.p_W, mark.covariance
        p_O = state.organ.targets[mark.name]
        return (state.found.X @ np.append(p_O, 1.0))[:3], state.found.target(p_O).covariance

    return tuple(replace(mark, newest=lambda mark=mark: newest(mark)) for mark in targets)  # type: ignore[misc]


def _next(dialogue: Dialogue) -> PlacedFrame:
    from palpate.viewer.stage import PlacedFrame

    def pose(_: Ticks) -> Array:
        X = np.eye(4)
        if dialogue.next_W is not None:
            X[:3, 3] = dialogue.next_W
        return X

    return PlacedFrame("touch here", np.eye(4), False, pose)
