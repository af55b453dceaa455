"""A session of registration with an operator: prompts in the terminal, touches taken when Enter is pressed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from rich.console import Console

from palpate.base.arrays import Array, so3
from palpate.base.errors import RegistrationError, SceneError
from palpate.cli.commands.register import _session
from palpate.cli.terminal.output import say
from palpate.scene import Scene, placing
from palpate.scene.registered import RegisteredOrgan, at, view_file
from palpate.sensing.trackers.tracker import Tracker
from palpate.world.registration import views
from palpate.world.registration.procedure import Procedure, from_landmarks
from palpate.world.registration.touches import Guess, touched_by

if TYPE_CHECKING:
    from palpate.simulators.room import Room

FELT = 0.05
"""Smallest force that counts as contact [N]."""


class Pointer(Protocol):
    """A tool whose tip touches the organ."""

    radius: float

    def read(self) -> Array:
        """Pose X_WT (4, 4) of the tool with its origin at the centre of its tip [m].

        Raises:
            RegistrationError: the tip touches nothing, or cannot be measured.
        """
        ...


class ArmPointer:
    """The tip of the follower in a running session; pressing is compensated by force over stiffness."""

    def __init__(self, scene: Scene, index: int, seed: int | None) -> None:
        from palpate.session import Session
        from palpate.simulators.room import Room

        self.session = Session(at(scene, Room(scene, seed).X_WA), seed=seed)
        self.radius = scene.contact.radius
        self._K = np.array(scene.objects[index].stiffness)

    def read(self) -> Array:
        """As in `Pointer`."""
        tick = self.session.latest()
        F = np.array(tick["F_spring_W"])
        if np.linalg.norm(F) < FELT:
            raise RegistrationError("no contact is felt", mend="press lightly onto the organ, then press Enter")
        return so3.pose(tick["p_WT"] + F / self._K, tick["quat_WT"])


@contextmanager
def pointer(scene: Scene, scanned: RegisteredOrgan, seed: int | None) -> Iterator[Pointer]:
    """The pointer of a scene: a tracked tool, or the arm of a session that runs meanwhile."""
    given = scanned.section.pointer
    if given is None:
        if scanned.section.simulated is None:
            what, where = "there is nothing to touch the organ with", scene.where("registration")
            mend = "give registration.pointer, a tool that a tracker sees, or registration.simulated"
            raise SceneError(what, where=where, mend=mend)
        arm = ArmPointer(scene, scanned.index, seed)
        arm.session.start()
        try:
            yield arm
        finally:
            arm.session.stop()
        return
    from palpate.sensing.trackers.pointer import TrackedPointer

    graph = placing.graph(at(scene, np.eye(4)))
    name = next((one.tracker for one in scene.frames if one.child == given.frame), None)
    tracker = _tracker(scene, name or "")
    try:
        yield TrackedPointer(scene, graph, tracker)
    finally:
        tracker.close()


class Dialogue:
    """The questions to the operator, and the procedure behind them.

    Args:
        console: for messages.
        scene: the scene.
        scanned: its organ.
        pointer: the tool that touches.
        ask: prints a prompt and returns the answer; raises EOFError at the end of the input.
        seed: seed of a simulated view; the scene's when None.
    """

    def __init__(
        self,
        console: Console,
        scene: Scene,
        scanned: RegisteredOrgan,
        pointer: Pointer,
        ask: Callable[[str], str] = input,
        seed: int | None = None,
    ) -> None:
        self._console, self._scene, self._scanned, self._pointer = console, scene, scanned, pointer
        self._ask, self._seed = ask, seed
        self.procedure: Procedure | None = None
        self.next_W: Array | None = None  #: place (3,) to touch next [m]

    def run(self) -> Procedure:
        """Ask for touches until the accuracy is met.

        Raises:
            RegistrationError: the operator ends the session, the touches disagree, or they are not enough.
        """
        given = self._scanned.section
        camera = given.camera
        if camera is None:
            first, again = self._first_by_landmarks(), None
        else:
            seen = views.seen(self._scanned.organ.points, self._view())
            stated = placing.graph(at(self._scene, np.eye(4))).pose(camera.frame)
            first, again = views.placed(seen, stated.X, stated.covariance), seen if camera.looks_again else None
        state = Procedure(
            self._scanned.organ, first, given.accuracy, 1e-3 * given.touch_mm, 1e-3 * given.tip_mm,
            self._pointer.radius, float("inf") if given.motion is None else given.motion, again,
        )  # fmt: skip
        self.procedure = state
        _session.progress(self._console, given, state)
        while not state.met:
            state.require_sound(given.touches)
            p_W, _ = state.next_place()
            self.next_W = p_W
            told = "not enough: " if state.X_WT else ""
            answer = self._asked(f"{told}{_touch_near(p_W)}, then Enter (u: undo, s: skip, q: quit) ")
            if answer == "s":
                state.skip(p_W)
            elif answer == "u" and state.X_WT:
                state.remove()
            elif not answer:
                state.add(self._taken(p_W))
                _session.progress(self._console, given, state)
        if camera is not None and state.view is not None:
            state.look_again(self._view(last=True))
        return state

    def touches_of(self, places_W: list[Array]) -> list[Array]:
        """Poses (4, 4) of the tool at these places (3,), which the operator touches or skips [m]."""
        taken = []
        for k, p_W in enumerate(places_W):
            self.next_W = p_W
            if not self._asked(f"{k + 1} of {len(places_W)}: {_touch_near(p_W)}, then Enter (s: skip, q: quit) "):
                taken.append(self._taken(p_W))
        if len(taken) < 4:
            raise RegistrationError(f"{len(taken)} places were touched", why="a check needs 4", mend="touch more")
        return taken

    def _taken(self, p_W: Array) -> Array:
        X_WT = self._read()
        away = 1e3 * float(np.linalg.norm(X_WT[:3, 3] - p_W))
        say(self._console, f"touched {away:.0f} mm from the proposed place")
        return X_WT

    def _read(self) -> Array:
        """The pointer's pose; asks again until it can be measured."""
        while True:
            try:
                return self._pointer.read()
            except RegistrationError as error:
                say(self._console, str(error), "not taken:", "yellow")
                self._asked("Enter to try again (q: quit) ")

    def _asked(self, prompt: str) -> str:
        try:
            answer = self._ask(prompt).strip().lower()
        except EOFError:
            answer = "q"
        if answer == "q":
            raise RegistrationError("the session was ended before its accuracy was met", why="nothing was written")
        return answer

    def _view(self, last: bool = False) -> Array:
        """Points (N, 3) that the camera sees before or after the touches: of a file, or simulated."""
        file = view_file(self._scene, last)
        if file is None:
            return self._room.look(self._scanned.index)
        from palpate.world.registration.cloud_files import read_cloud

        if last:
            self._asked(f"write the points that the camera sees now to {file}, then Enter (q: quit) ")
        return read_cloud(file)

    @cached_property
    def _room(self) -> Room:
        from palpate.simulators.room import Room

        return Room(self._scene, self._seed)

    def _first_by_landmarks(self) -> Guess:
        """First pose from landmarks that the operator finds and touches."""
        given, X_WT = self._scanned.section, []
        for name in self._scanned.landmarks:
            while self._asked(f"touch the landmark {name!r}, then Enter (q: quit) "):
                pass
            X_WT.append(self._read())
        touched = touched_by(X_WT, self._pointer.radius, 1e-3 * given.touch_mm, 1e-3 * given.tip_mm)
        return from_landmarks(self._scanned.organ, self._scanned.landmarks, touched, 1e-3 * given.landmark_mm)


def _touch_near(p_W: Array) -> str:
    return f"touch near ({', '.join(f'{1e3 * x:+.0f}' for x in p_W)}) mm in the world"


def _tracker(scene: Scene, name: str) -> Tracker:
    """The tracker of this name.

    Raises:
        SceneError: there is none. MissingExtraError: a part that it needs is not installed.
    """
    if name not in scene.trackers:
        where = scene.where("registration", "pointer")
        raise SceneError(
            "the pointer's frame is not tracked", where=where, mend="give its entry in frames tracker: NAME"
        )
    address = scene.trackers[name].openigtlink
    if address is not None:
        from palpate.sensing.trackers.openigtlink import OpenIGTLinkTracker

        return OpenIGTLinkTracker(address)
    from palpate.scene.rig import build
    from palpate.sensing.trackers.tracking import simulated

    truth = scene.registration.simulated if scene.registration is not None else None
    return simulated(build(at(scene, np.eye(4) if truth is None else truth.pose.matrix())), name)
