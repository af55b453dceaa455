"""Films a record: both eyes of its endoscope at every frame of an episode, as H.264."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError
from palpate.export.demonstration import ArmOfRun, Demonstration
from palpate.export.episode import Episode
from palpate.export.video.arms import ArmBodies
from palpate.export.video.drawing import Body, Canvas, Image
from palpate.export.video.solids import SolidBodies
from palpate.record.reader import Record
from palpate.record.snapshots import CAMERA, Track
from palpate.scene import placed_ecm
from palpate.scene.ecm import EcmSection
from palpate.scene.hand import HandPlan
from palpate.scene.model import ObjectSection
from palpate.scene.placed_ecm import PlacedEcm
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.scene.soft import is_soft, rest_shape
from palpate.session.recorded import body_track, recorded_scene, shape_track
from palpate.world.mesh.coarse import MOST_TRIANGLES

SIZE = (720, 1280)
"""Height and width of a picture [pixels]."""
Eye = Literal["left", "right"]
EYES: tuple[Eye, ...] = ("left", "right")
_TISSUE = ((170, 62, 52), (205, 140, 110), (150, 165, 100), (200, 165, 125))
_EVERY = 10  # frames between two that the statistics take
_COARSE = 8  # pixels between two that they take
_ENCODER = {"preset": "ultrafast", "crf": "23", "g": "10"}  # a key frame each third of a second: for random access


@dataclass(frozen=True)
class Clip:
    """A film of one eye."""

    file: Path
    samples: Array
    """(n, 3) colours of some pixels, 0 to 1, for the statistics."""
    size: tuple[int, int]
    """Height and width [pixels]."""
    stamps: NDArray[np.int64] | None = None
    """(n,) stamps of the pictures of a camera [ns]."""


class Film:
    """What a run shows, ready to be drawn at any of its frames.

    Args:
        run: a run of records with their scene.
        size: height and width of a picture [pixels].

    Raises:
        SceneError: the scene of the record cannot be read. MissingExtraError, PalpateError: as `Canvas`.
    """

    def __init__(self, run: Demonstration, size: tuple[int, int] = SIZE) -> None:
        first = run.arms[0].ticks
        assert isinstance(first, Record), "the cameras of a bag are filmed by BagFilm"
        self.record, self.size = first, size
        scene = recorded_scene(first)
        self.ecm = _endoscope(scene, [arm.ticks for arm in run.arms if isinstance(arm.ticks, Record)])
        self.canvas = Canvas(size, self.ecm.section.endoscope.width_deg)
        self._camera = first.snapshots(CAMERA)
        self._soft: list[tuple[Body, Array, Track]] = []
        self._moving: list[tuple[Body, Callable[[float], Array]]] = []
        self._add_objects(scene, first)
        self.solids = SolidBodies(self.canvas, scene)
        self._body_track = body_track(first)
        self._arms = [self._arm(arm) for arm in run.arms]

    @property
    def intrinsics(self) -> dict[str, Any]:
        """Intrinsics of an eye: a pinhole without distortion [pixels], and the distance of the eyes [m]."""
        height, width = self.size
        f = 0.5 * width / np.tan(0.5 * np.radians(self.ecm.section.endoscope.width_deg))
        eye = {"fx": f, "fy": f, "cx": 0.5 * width, "cy": 0.5 * height, "width": width, "height": height,
               "distortion_model": "opencv_radtan", "distortion": [0.0, 0.0, 0.0, 0.0]}  # fmt: skip
        return {**{f"endoscope.{side}": eye for side in EYES}, "baseline_m": self.ecm.section.endoscope.baseline}

    def pictures(self, episode: Episode) -> Iterator[dict[Eye, Image]]:
        """The picture (h, w, 3) of each eye at every frame."""
        for k, t in enumerate(episode.arms[0].frames.t.tolist()):
            for bodies, arm in zip(self._arms, episode.arms, strict=True):
                bodies.move(arm.frames.q[k], arm.frames.jaw[k, 0])
            for body, rest, track in self._soft:
                body.replace(rest + track.at(t))
            for body, pose in self._moving:
                body.X_WB = pose(t)
            if self._body_track is not None:
                self.solids.move(self._body_track.at(t))
            q = self.ecm.q0 if self._camera is None else self._camera.at(t)
            yield {side: self.canvas.picture(self.ecm.eye(q, side)) for side in EYES}

    def shoot(self, episode: Episode, folder: Path, fps: int) -> dict[str, Clip]:
        """Write the film of each eye into a folder, by the name of its feature."""
        files = {side: folder / f"{side}.mp4" for side in EYES}
        return films(self.pictures(episode), files, dict.fromkeys(EYES, self.size), fps)

    def close(self) -> None:
        """Release what draws."""
        self.canvas.close()

    def _add_objects(self, scene: Scene, record: Record) -> None:
        """Draw the objects as the loop had them: soft ones by their recorded shapes, moving ones by their motion."""
        rig = build(scene)
        for k, (section, placed, felt) in enumerate(
            zip(scene.objects, rig.surfaces, rig.snapshot.objects, strict=True)
        ):
            track = shape_track(record, section.name) if is_soft(felt) else None
            vertices, triangles = rest_shape(felt) or placed.drawable(MOST_TRIANGLES)
            rests = track is None and not section.motion
            body = self.canvas.add(vertices, triangles, color_of(section, k), 0.25, placed.X_WO if rests else None)
            body.X_WB = placed.X_WO
            if track is not None:
                self._soft.append((body, vertices, track))
            if section.motion:
                self._moving.append((body, felt.pose))

    def _arm(self, one: ArmOfRun) -> ArmBodies:
        assert isinstance(one.ticks, Record)
        scene = recorded_scene(one.ticks)
        base = scene.arms.follower.base
        return ArmBodies(self.canvas, scene.arm("follower"), np.eye(4) if base is None else base.matrix())


def films(
    pictures: Iterable[Mapping[Eye, Image]], files: Mapping[Eye, Path], sizes: Mapping[Eye, tuple[int, int]], fps: int
) -> dict[str, Clip]:
    """Write the film of each eye from pictures (h, w, 3) of equal times; by the name of its feature.

    Each eye is encoded by a thread of its own, while the next pictures are made.
    """
    writers = {side: _Writer(file, sizes[side], fps) for side, file in files.items()}
    samples: dict[Eye, list[NDArray[Any]]] = {side: [] for side in files}
    with ThreadPoolExecutor(len(files), "palpate-film") as pool:
        encoding: list[Future[None]] = []
        for k, shown in enumerate(pictures):
            for one in encoding:
                one.result()
            encoding = [pool.submit(writers[side].add, shown[side]) for side in files]
            for side in files if k % _EVERY == 0 else ():
                samples[side].append(shown[side][::_COARSE, ::_COARSE].reshape(-1, 3) / 255.0)
        for one in encoding:
            one.result()
    return {
        f"observation.images.endoscope.{side}": Clip(writers[side].close(), np.concatenate(samples[side]), sizes[side])
        for side in files
    }


class _Writer:
    """An H.264 file."""

    def __init__(self, file: Path, size: tuple[int, int], fps: int) -> None:
        try:
            import av
        except ImportError:
            raise MissingExtraError("av, which writes video,", "learning") from None
        self._av, self.file = av, file
        self._out = av.open(str(file), "w")
        self._stream = self._out.add_stream("libx264", rate=fps, options=_ENCODER)
        self._stream.height, self._stream.width = size
        self._stream.pix_fmt = "yuv420p"

    def add(self, picture: Image) -> None:
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        self._out.mux(self._stream.encode(frame))

    def close(self) -> Path:
        self._out.mux(self._stream.encode())
        self._out.close()
        return self.file


def _endoscope(scene: Scene, records: Sequence[Record]) -> PlacedEcm:
    """The endoscope of a scene; if it has none, one that sees the middle between the starts of all hands."""
    starts = [record.read(["p_WT"], 0, 1)["p_WT"][0] for record in records]
    return endoscope(scene, np.mean(starts, axis=0))


def color_of(section: ObjectSection, number: int) -> tuple[int, ...]:
    """Colour of an object in a picture: its own, or one of those of tissue by its number."""
    return section.color or _TISSUE[number % len(_TISSUE)]


def endoscope(scene: Scene, p_W: Array) -> PlacedEcm:
    """The endoscope of a scene; one that sees a point (3,) in W [m] if the scene has none."""
    return placed_ecm.place(scene, scene.ecm or EcmSection(), HandPlan(np.zeros(1), p_W[None]))
