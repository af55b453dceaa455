"""Virtual fixtures in the view: allowed regions green, forbidden ones red; controls to switch and move them."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from viser.transforms import SE3, SO3

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.scene.guidance.steered import SteeredFixtures
from palpate.viewer.labels import Label, point_of
from palpate.viewer.stage import FixtureMark
from palpate.world.mesh.coarse import coarser

ALLOWED, FORBIDDEN = (42, 157, 92), (200, 55, 45)
SOLID, MARGIN, OFF = 0.35, 0.15, 0.06
"""Opacity [-] of the geometry, of its margin, and of both while the fixture is off."""
CURVE = 0.0012
"""Width of a drawn curve [m]."""
LABEL = np.array([0.0, 0.0, 0.012])
"""Offset of the name from the middle [m]."""
LIGHT_TRIANGLES = 2000
"""Number of triangles of a body in a light picture; what is transparent is drawn twice, its far side first."""
HANDLE = 0.05
"""Size of the handle that moves a fixture [m]."""


class FixtureDrawing:
    """One fixture under its own frame, which moves with the frame of attachment and with the handle."""

    def __init__(self, scene: viser.SceneApi, mark: FixtureMark) -> None:
        self._mark, self._moved = mark, np.eye(4)
        name, colour = f"/fixtures/{mark.name}", FORBIDDEN if mark.forbids else ALLOWED
        self._frame = scene.add_frame(name, show_axes=False)
        self._bodies: list[tuple[Any, float]] = []
        self._finer: dict[int, tuple[Array, NDArray[np.int32]]] = {}  # bodies of many triangles, by their number
        self.is_light = False
        for k, (vertices, triangles, opacity) in enumerate(
            ((mark.vertices, mark.triangles, SOLID), (mark.margin_vertices, mark.margin_triangles, MARGIN))
        ):
            if len(triangles):
                mesh = scene.add_mesh_simple(
                    f"{name}/{k}", vertices.astype(np.float32), triangles.astype(np.uint32), color=colour,
                    opacity=opacity, side="double", cast_shadow=False, receive_shadow=False,
                )  # fmt: skip
                if len(triangles) > LIGHT_TRIANGLES:
                    self._finer[len(self._bodies)] = vertices, triangles
                self._bodies.append((mesh, opacity))
        if len(mark.curve) > 1:
            scene.add_spline_catmull_rom(f"{name}/curve", points=mark.curve, thickness=CURVE, color=colour)
        elif len(mark.curve):
            scene.add_icosphere(f"{name}/point", 2 * CURVE, colour, position=mark.curve[0], cast_shadow=False)
        above = mark.middle + LABEL
        label = scene.add_label(f"{name}/name", mark.name, position=above, anchor="bottom-center")
        self.label = Label(label, lambda: point_of(self._frame, above))
        self.show(0.0)

    def switch(self, on: bool) -> None:
        """Draws the fixture pale while it is off."""
        for mesh, opacity in self._bodies:
            mesh.opacity = opacity if on else OFF

    def set_light(self, light: bool) -> None:
        """Draws at most about `LIGHT_TRIANGLES` triangles of each body, or all of them again."""
        if light == self.is_light:
            return
        self.is_light = light
        for k, (vertices, triangles) in self._finer.items():
            points, faces = coarser(vertices, triangles, LIGHT_TRIANGLES)[:2] if light else (vertices, triangles)
            mesh, _ = self._bodies[k]
            mesh.vertices, mesh.faces = points.astype(np.float32), faces.astype(np.uint32)

    def move(self, X_W: Array) -> None:
        """Sets the displacement by the handle, (4, 4), relative to the pose in the scene."""
        self._moved = X_W

    def show(self, t: float) -> None:
        """Moves the fixture to its pose at time t [s]."""
        X = SE3.from_matrix(self._moved @ (np.eye(4) if self._mark.moving is None else self._mark.moving(t)))
        self._frame.wxyz, self._frame.position = X.rotation().wxyz, X.translation()


class FixturePanel:
    """A switch, an authority slider and a handle for every fixture; each change sends a new list to the loop."""

    def __init__(
        self,
        server: viser.ViserServer,
        marks: tuple[FixtureMark, ...],
        drawings: list[FixtureDrawing],
        steered: SteeredFixtures,
    ) -> None:
        self._steered = steered
        self.on: dict[str, viser.GuiCheckboxHandle] = {}
        self.authority: dict[str, viser.GuiSliderHandle[float]] = {}
        self.handle: dict[str, viser.TransformControlsHandle] = {}
        with server.gui.add_folder("Guidance"):
            for mark, drawing in zip(marks, drawings, strict=True):
                self._add(server, mark, drawing)

    def _add(self, server: viser.ViserServer, mark: FixtureMark, drawing: FixtureDrawing) -> None:
        name, section = mark.name, self._steered[mark.name].section
        words = f"{section.role.name}, {section.law.name}{', hard' if section.hard else ''}"
        on = server.gui.add_checkbox(name, section.enabled, hint=words)
        weight = server.gui.add_slider("authority (share of its force)", 0.0, 1.0, 0.05, section.authority)
        grip = server.gui.add_checkbox("move it", False, hint="Shows a handle that moves and turns the fixture")
        handle = server.scene.add_transform_controls(
            f"/handles/{name}", scale=HANDLE, position=mark.middle, visible=False, depth_test=False
        )
        drawing.switch(section.enabled)
        self.on[name], self.authority[name], self.handle[name] = on, weight, handle

        @on.on_update
        def _(_: object) -> None:
            drawing.switch(on.value)
            self._steered.change(name, enabled=on.value)

        @weight.on_update
        def _(_: object) -> None:
            self._steered.change(name, authority=weight.value)

        @grip.on_update
        def _(_: object) -> None:
            handle.visible = grip.value

        @handle.on_update
        def _(_: object) -> None:
            X = _moved(handle, mark.middle)
            drawing.move(X)
            self._steered.change(name, X_W=X)


def _moved(handle: viser.TransformControlsHandle, middle: Array) -> Array:
    """Displacement (4, 4) of a fixture whose handle started at `middle` without rotation."""
    X = SE3.from_rotation_and_translation(SO3(np.array(handle.wxyz)), np.array(handle.position)).as_matrix()
    X[:3, 3] -= X[:3, :3] @ middle
    return np.asarray(X)


def in_words(tick: Ticks, names: tuple[str, ...]) -> str:
    """Action of guidance at a tick: `vessel: 1.20 N; the goal is kept 0.4 mm back`; empty without any."""
    i = int(tick["guidance_fixture"])
    if not 0 <= i < len(names):
        return ""
    force, moment = (float(np.linalg.norm(tick[key])) for key in ("F_guidance_W", "t_guidance_W"))
    strength = f"{force:.2f} N" if force >= 0.005 else f"{1e3 * moment:.1f} mN m"
    corrected = 1e3 * float(np.linalg.norm(tick["p_correction_W"]))
    rest = f"; the goal is kept {corrected:.1f} mm back" if corrected >= 0.05 else ""
    return f"{names[i]}: {strength}{rest}"
