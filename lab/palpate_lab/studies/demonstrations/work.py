"""The work of ``palpate study demonstrations``: one episode by a simulated operator in closed loop, kept as frames."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TypedDict

import numpy as np

from palpate.arm.hands import Hand
from palpate.base.arrays import Array
from palpate.base.errors import SceneError, SweepError
from palpate.base.sweep.grid import Point
from palpate.export.demonstration import leader_name
from palpate.export.episode import ArmOfEpisode, Episode
from palpate.export.frames import ArmFrames, frames_of
from palpate.record.ticks import Ticks, as_rows, as_ticks
from palpate.scene.operator import PalpateSection, WayPoint
from palpate.scene.overrides import override
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies, PlacedSurface
from palpate.simulators.operators import Errand, Operator, Senses, perform, person
from palpate.simulators.operators.operator import MAX_SPEED

WIDTH = 0.0015
"""Width of the passage for the steering law: operators stroke with some 12 mm/s [m]."""
HOVER = 0.002
"""Height of the start above the surface [m]."""
_SAMPLE = 5e-4  # spacing of a path [m]
_FORCES = (0.7, 1.3)  # range of the intended force over that of the scene
_TOUCHING, _ERROR = 0.5, 0.5  # least share of the time in contact, and largest mean relative error of its force


@dataclass(frozen=True)
class Plan:
    """What all episodes share."""

    scenes: tuple[Scene, ...]
    vary: tuple[tuple[str, float, float], ...]
    """Ranges of values of the scene, by their path."""
    operators: int
    """Number of people in the cohort, who take turns."""
    seed: int
    seconds: float
    """Length of an episode [s]."""
    spread: float
    """Largest distance of the place from the one of the scene, along x and y of W [m]."""
    fps: int
    folder: str
    """Where the frames of finished episodes are kept."""


class Outcome(TypedDict):
    """What the journal holds of an episode."""

    frames: int
    done: bool
    touching: float
    peak_N: float
    error: float


@dataclass(frozen=True)
class Taken:
    """Ticks of a simulation in memory, read as a record."""

    ticks: Ticks
    rate: float = 1000.0

    def __len__(self) -> int:
        """Number of ticks."""
        return len(self.ticks)

    def read(self, signals: Sequence[str], start: int = 0, stop: int | None = None) -> Ticks:
        """All signals of some ticks."""
        return self.ticks[start:stop]


_SURFACES: dict[str, Bodies] = {}
"""Surfaces by the scene, which the episodes of a worker share."""


def episode(point: Point, seed: int, *, plan: Plan) -> Outcome:
    """Perform episode number ``point["episode"]`` and keep its frames. The seed of the sweep is the episode's own."""
    number = int(point["episode"])
    scene = plan.scenes[number % len(plan.scenes)]
    rng = np.random.default_rng(seed)
    who = person(number % plan.operators, plan.seed)
    values = {name: float(rng.uniform(low, high)) for name, low, high in plan.vary}
    rig, errand = _task(override(scene, values), who.hand, who.tremor, rng, plan)
    kept: list[Array] = []
    sim = rig.simulation(int(rng.integers(2**31)))
    operator = Operator(who, Senses("felt"), int(rng.integers(2**31)))
    perform(
        sim, operator, errand, rig.arms.X_WL, rig.scene.mapping.scale, plan.seconds,
        lambda ticks: kept.append(as_rows(ticks).copy()),
    )  # fmt: skip
    ticks = as_ticks(np.concatenate(kept))[: round(1000 * plan.seconds)]  # numpy joins structures 50 times as slowly
    frames = frames_of(Taken(ticks), plan.fps)
    _keep(Path(plan.folder), number, frames)
    return _judged(ticks, len(frames), errand.press)


def _judged(ticks: Ticks, frames: int, press: float) -> Outcome:
    """A demonstration is done if it touched for half of the time, with the intended force within half of it."""
    force = np.linalg.norm(ticks["F_T_W"], axis=1)
    touching = force > 0.0
    error = float(np.mean(np.abs(force[touching] - press)) / press) if touching.any() else 1.0
    share = float(np.mean(touching))
    done = share >= _TOUCHING and error <= _ERROR
    return Outcome(frames=frames, done=done, touching=share, peak_N=float(force.max()), error=error)


def _task(scene: Scene, hand: Hand, tremor: float, rng: np.random.Generator, plan: Plan) -> tuple[Rig, Errand]:
    """The scene with the hand of a person at the start of a task, and the task: strokes over a place."""
    bodies = _SURFACES.setdefault(scene.file or scene.title, {})
    section = scene.operator.palpate
    still = build(scene, bodies, until=0.0)
    index = next((k for k, obj in enumerate(scene.objects) if obj.name == section.object), 0)
    surface = still.surfaces[index]
    about = np.asarray(section.at if section.at is not None else surface.top)
    place = about + np.append(rng.uniform(-plan.spread, plan.spread, 2), 0.0)
    force = section.force * float(rng.uniform(*_FORCES))
    q, n = (rows[0] for rows in surface.nearest(place[None]))
    path = _strokes(surface, q, n, section, float(rng.uniform(0.0, np.pi)), scene.contact.radius, plan.seconds)
    stiffness = float(n @ np.diag(scene.objects[index].stiffness) @ n)
    into = (-float(n[0]), -float(n[1]), -float(n[2]))
    errand = Errand(path, np.full(len(path), WIDTH), stiffness, force, into, rendered=True)
    start = path[0] + HOVER * n
    own = {key: getattr(hand, key) for key in ("mass", "damping", "stiffness")}
    at_start = {"palpate": PalpateSection(), "path": (WayPoint(t=0.0, xyz=tuple(start.tolist())),)}
    operator = scene.operator.model_copy(update={**at_start, "tremor": tremor, **own})
    placed = scene.model_copy(update={"operator": operator}).with_file_of(scene)
    return build(placed, bodies), errand


def _strokes(
    surface: PlacedSurface, q: Array, n: Array, section: PalpateSection, angle: float, radius: float, seconds: float
) -> Array:
    """Path (m, 3) of the tip over the surface in figures of eight, which have no sharp turn, long enough for a time."""
    along = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    along /= np.linalg.norm(along)
    along = np.cos(angle) * along + np.sin(angle) * np.cross(n, along)
    across, size = np.cross(n, along), 0.5 * section.length
    count = max(8, round(3.0 * section.length / _SAMPLE))
    u = 2.0 * np.pi * np.arange(count) / count
    eight = size * (np.sin(u)[:, None] * along + 0.3 * np.sin(2.0 * u)[:, None] * across)
    places, normals = surface.nearest(q + eight + 0.005 * n)
    once = places + radius * normals
    return np.tile(once, (1 + int(MAX_SPEED * seconds / (2.0 * section.length)), 1))


def part_of(folder: Path, number: int) -> Path:
    """File of the frames of an episode."""
    return folder / f"episode_{number:06d}.npz"


def _keep(folder: Path, number: int, frames: ArmFrames) -> None:
    """Write the frames of an episode; the file appears whole."""
    file = part_of(folder, number)
    draft = file.with_name(f".{file.stem}-{os.getpid()}.npz")
    np.savez(draft, **{f.name: getattr(frames, f.name) for f in fields(ArmFrames)})
    draft.rename(file)


def taken_up(plan: Plan, number: int, outcome: Mapping[str, object]) -> Episode:
    """A finished episode, from its file.

    Raises:
        SweepError: the file is not there, as on another machine of a cluster.
    """
    file = part_of(Path(plan.folder), number)
    try:
        with np.load(file) as data:
            frames = ArmFrames(**{f.name: data[f.name] for f in fields(ArmFrames)})
    except OSError:
        what, mend = (
            "the frames of a finished episode are missing",
            "give an --out that all workers share, and run again",
        )
        raise SweepError(what, where=str(file), mend=mend) from None
    scene = plan.scenes[number % len(plan.scenes)]
    sides = {side: Path(str(getattr(scene.arms, side).model)).stem for side in ("leader", "follower")}
    arm = ArmOfEpisode(
        "psm1",
        leader_name(sides["leader"], 1),
        sides["follower"],
        tuple(scene.arm("follower").joint_names),
        tuple(scene.arm("leader").joint_names),
        frames,
    )
    stamps = np.rint(1e9 * (frames.t - frames.t[0])).astype(np.int64)
    name = scene.operator.palpate.object or scene.objects[0].name
    return Episode(f"episode {number}", f"palpate the {name}", (arm,), stamps, not outcome["done"])


def require_palpation(scene: Scene) -> None:
    """Refuse a scene whose hand follows way points, or that has several pairs.

    Raises:
        SceneError: as said.
    """
    if scene.operator.path is not None or scene.pairs:
        what = "demonstrations are made of scenes whose one hand palpates"
        why = "it has several pairs" if scene.pairs else "its operator follows way points"
        raise SceneError(what, where=scene.where("operator"), why=why, mend="give operator: {palpate: ...}")
