"""The 3-D view: every object is drawn once, and `Drawing.show(tick)` moves it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import viser
from numpy.typing import NDArray

from palpate.arm.ecm import Ecm
from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.scene.placed_ecm import PlacedEcm
from palpate.viewer.arms import ArmDrawing, Color
from palpate.viewer.cue import Cues, ForceCue
from palpate.viewer.device import DeviceDrawing
from palpate.viewer.fixtures import FixtureDrawing
from palpate.viewer.frames import FrameDrawing
from palpate.viewer.organs import OrganDrawing
from palpate.viewer.plane import PlaneDrawing
from palpate.viewer.rod import RodDrawing
from palpate.viewer.stage import ArmPlace, Stage, TouchedObject
from palpate.viewer.targets import TargetDrawing
from palpate.viewer.tool import Presses, ToolDrawing

if TYPE_CHECKING:
    from palpate import _network

RED: Color = (200, 0, 0)
GREEN: Color = (0, 130, 30)
TISSUE: list[Color] = [(140, 40, 32), (196, 120, 92), (120, 140, 70), (190, 150, 110)]
DRAPE: Color = (46, 104, 116)

FORCE_SCALE = 0.06
"""Length of a force arrow [m/N]."""
DEFLECTION_SCALE = 10.0
"""Length of the deflection arrow over the deflection [-]."""


class Arrow:
    """An arrow that is hidden while it is too short to see."""

    def __init__(self, scene: viser.SceneApi, name: str, color: Color, radius: float) -> None:
        """`radius`: radius of the shaft [m]; the head is in proportion."""
        self._handle = scene.add_arrows(
            name,
            np.zeros((1, 2, 3), dtype=np.float32),
            color,
            shaft_radius=radius,
            head_radius=2.4 * radius,
            head_length=5.0 * radius,
            visible=False,
        )
        self._shortest = 2.0 * radius
        self.enabled = True

    def show(self, start: Array, vector: Array) -> None:
        """Draws the arrow from `start` (3,) along `vector` (3,), both in W [m]."""
        seen = self.enabled and float(np.linalg.norm(vector)) > self._shortest
        if seen:
            self._handle.points = np.stack([start, start + vector])[None].astype(np.float32)
        if self._handle.visible != seen:
            self._handle.visible = seen


class Drawing:
    """Arms, organs, tool sphere, proxy and arrows of one stage."""

    def __init__(
        self,
        scene: viser.SceneApi,
        stage: Stage,
        world: bool = True,
        tint: Color | None = None,
        cues: Cues | None = None,
    ) -> None:
        """Draws everything once.

        Args:
            scene: where to draw.
            stage: what to draw.
            world: False leaves out light, drape, objects and rod, which another drawing of the same scene shows.
            tint: colour that is mixed into those of the arms.
            cues: force cues of a condition; None: those of the stage, which a box switches.
        """
        self._stage = stage
        if world:
            _light(scene)
            _drape(scene, stage)
        shared = stage.objects if world else []
        self._organs = [OrganDrawing(scene, t, TISSUE[k % len(TISSUE)]) for k, t in enumerate(shared)]
        self._leader = ArmDrawing(scene, stage.leader, tint) if stage.device is None else None
        self.device = None if stage.device is None else DeviceDrawing(scene, stage.device)
        self._follower = ArmDrawing(scene, stage.follower, tint)
        self._ecm = None if stage.ecm is None or not world else ArmDrawing(scene, _ecm_place(stage.ecm))
        self._rod = None if stage.rod is None or not world else RodDrawing(scene, stage.rod)
        self._tool = ToolDrawing(scene, stage)
        self._plane = PlaneDrawing(scene)
        self.cue = ForceCue(scene, stage) if cues is None else ForceCue(scene, stage, cues, enabled=True)
        self.fixtures = [FixtureDrawing(scene, mark) for mark in stage.fixtures]
        self._frames = [FrameDrawing(scene, frame) for frame in stage.frames if world]
        self.targets = [TargetDrawing(scene, mark) for mark in stage.targets if world]
        self.labels = [*(one.label for one in self.fixtures), *(one.label for one in self._frames)]
        self.labels += [one.named for one in self.targets]
        self.deflection = Arrow(scene, "/arrows/deflection", RED, 0.0016)
        self.force_body = Arrow(scene, "/arrows/force_body", RED, 0.0030)
        self.force_spatial = Arrow(scene, "/arrows/force_spatial", GREEN, 0.0030)

    def see_through(self, share: float) -> None:
        """Sets the transparency, 0 opaque, up to 0.9: of the objects that hold something, or else of all."""
        holding = [organ for organ in self._organs if organ.holds]
        for organ in holding or self._organs:
            organ.see_through(share)

    def deform(self, index: int, vertices: Array, bands: NDArray[np.int64] | None = None) -> None:
        """Draws a soft object as deformed; see `OrganDrawing.deform`."""
        self._organs[index].deform(vertices, bands)

    def set_light(self, light: bool) -> None:
        """Draws objects and fixtures with fewer triangles, for a browser without a graphics card."""
        for organ in self._organs:
            organ.set_light(light)
        for fixture in self.fixtures:
            fixture.set_light(light)

    def show_frames(self, shown: bool) -> None:
        """Shows or hides the frames of the scene."""
        for frame in self._frames:
            frame.node.visible = shown

    def show_ecm(self, q: Array) -> None:
        """Moves the endoscope arm to its joints q (4,) [rad, m]."""
        if self._ecm is not None:
            self._ecm.show(q, 0.0)

    def show_plane(self, plane: Callable[[], _network.ModelEstimate | None] | None) -> None:
        """Shows the plane that the hand feels where the scene has no object, as it is now; None: there is no link."""
        self._plane.show(None if plane is None else plane(), self.p_WT)

    @property
    def p_WT(self) -> Array:
        """Drawn position of the tool tip (3,) [m]."""
        return self._tool.p_WT

    def show(self, tick: Ticks, others: Sequence[Presses] = ()) -> Presses:
        """Moves everything to one tick (a 0-d structured array or a row of one).

        others: contacts of other tools with the objects, which dent them as well.

        Returns:
            The contacts of this tool.
        """
        if self._leader is not None:
            self._leader.show(tick["q"], float(tick["gripper"]))
        if self.device is not None:
            self.device.show(tick)
        links = self._follower.show(tick["q_follower"], float(tick["jaw"]))
        shift = self.cue.shift(tick)
        self._follower.shift(shift)
        self._tool.show(tick, links, shift)
        self.cue.show(tick)
        presses = self._tool.presses(tick, self.cue.dent(tick))
        for k, organ in enumerate(self._organs):
            organ.show(tick)
            organ.press([one for each in (presses, *others) for one in each.get(k, [])])
        if self._rod is not None:
            self._rod.show(tick)
        for fixture in self.fixtures:
            fixture.show(float(tick["t"]))
        for frame in self._frames:
            frame.show(tick)
        for target in self.targets:
            target.show()
        p_WT = np.array(tick["p_WT"])
        p_WS = np.array(tick["p_WP"]) - tick["delta_x"] if float(tick["contacts"]) > 0 else p_WT  # the sphere's centre
        self.deflection.show(p_WS, DEFLECTION_SCALE * np.array(tick["delta_x"]))
        X_WL = self._stage.leader.X_WA
        p_WH = X_WL[:3, :3] @ tick["p_LH"] + X_WL[:3, 3]
        self.force_spatial.show(p_WH, FORCE_SCALE * (X_WL[:3, :3] @ tick["F_H_L"]))
        self.force_body.show(p_WH, FORCE_SCALE * (X_WL[:3, :3] @ tick["F_H_H"]))
        return presses


def _ecm_place(placed: PlacedEcm) -> ArmPlace:
    """The endoscope arm with an instance of its own, at its joints at the start."""
    arm = Ecm(placed.ecm.tilt_deg).arm
    arm.home = placed.q0
    return ArmPlace("ecm", arm, placed.X_WB)


def _light(scene: viser.SceneApi) -> None:
    """A lamp above the table with soft shadows, and enough ambient light to see into hollows."""
    scene.set_up_direction("+z")
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map("studio", environment_intensity=0.12)
    scene.add_light_ambient("/light/ambient", intensity=0.5)
    scene.add_light_directional(
        "/light/lamp", intensity=1.5, cast_shadow=True, position=(-0.4, -0.7, 1.4), color=(255, 248, 238)
    )
    scene.add_light_directional("/light/fill", intensity=0.4, position=(0.9, -0.6, 0.5), color=(225, 235, 255))
    shade = np.linspace(0.0, 1.0, 256)[:, None, None] ** 1.3
    sky = (1.0 - shade) * np.array([226, 233, 238]) + shade * np.array([250, 251, 252])
    scene.set_background_image(np.broadcast_to(sky, (256, 16, 3)).astype(np.uint8))


def _drape(scene: viser.SceneApi, stage: Stage) -> None:
    if not stage.objects:
        return  # a stage without objects
    corners = np.concatenate([_corners(t) for t in stage.objects])
    low, middle = corners[:, 2].min(), 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    size = 1.6 * np.ptp(corners, axis=0)[:2].max() + 0.08
    scene.add_box(
        "/drape", DRAPE, (size, 0.8 * size, 0.008), position=(middle[0], middle[1], low - 0.006), cast_shadow=False
    )
    front = corners[:, 1].min() - 0.02
    _scale_bar(scene, np.array([middle[0] - 0.025, max(front, middle[1] - 0.37 * size), low]))


def _scale_bar(scene: viser.SceneApi, start: Array) -> None:
    """A bar of 50 mm on the drape in front of the objects, in two halves."""
    x, y, z = start.tolist()
    for k, color in enumerate(((30, 30, 30), (240, 240, 240))):
        scene.add_box(
            f"/scale/{k}", color, (0.025, 0.004, 0.002), position=(x + 0.0125 + 0.025 * k, y, z), cast_shadow=False
        )
    scene.add_label("/scale/text", "50 mm", position=(x + 0.055, y, z), anchor="center-left")


def _corners(obj: TouchedObject) -> Array:
    p_WV = obj.vertices @ obj.X_WO[:3, :3].T + obj.X_WO[:3, 3]
    return np.stack([p_WV.min(axis=0), p_WV.max(axis=0)])
