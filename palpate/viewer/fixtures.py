"""Virtual fixtures in the view: allowed green, forbidden red; switches, weights, and handles to move them."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from viser.transforms import SE3, SO3

from palpate.arrays import Array
from palpate.guidance.steered import SteeredFixtures
from palpate.record.ticks import Ticks
from palpate.viewer.stage import FixtureMark

ALLOWED, FORBIDDEN = (42, 157, 92), (200, 55, 45)
SOLID, MARGIN, OFF = 0.35, 0.15, 0.06
"""How opaque: the geometry, its margin, and both while it is switched off."""
CURVE = 0.0012
"""Width of a drawn curve [m]."""
LABEL = np.array([0.0, 0.0, 0.012])
"""Of the name, above the middle [m]."""
HANDLE = 0.05
"""Size of the handle that moves a fixture [m]."""


class FixtureDrawing:
    """One fixture under a frame of its own, which moves with what it is attached to and with its handle."""

    def __init__(self, scene: viser.SceneApi, mark: FixtureMark) -> None:
        self._mark, self._moved = mark, np.eye(4)
        name, colour = f"/fixtures/{mark.name}", FORBIDDEN if mark.forbids else ALLOWED
        self._frame = scene.add_frame(name, show_axes=False)
        self._bodies: list[tuple[Any, float]] = []
        for k, (vertices, triangles, opacity) in enumerate(
            ((mark.vertices, mark.triangles, SOLID), (mark.margin_vertices, mark.margin_triangles, MARGIN))
        ):
            if len(triangles):
                mesh = scene.add_mesh_simple(
                    f"{name}/{k}", vertices.astype(np.float32), triangles.astype(np.uint32), color=colour,
                    opacity=opacity, side="double", cast_shadow=False, receive_shadow=False,
                )  # fmt: skip
                self._bodies.append((mesh, opacity))
        if len(mark.curve) > 1:
            scene.add_spline_catmull_rom(f"{name}/curve", points=mark.curve, thickness=CURVE, color=colour)
        elif len(mark.curve):
            scene.add_icosphere(f"{name}/point", 2 * CURVE, colour, position=mark.curve[0], cast_shadow=False)
        scene.add_label(f"{name}/name", mark.name, position=mark.middle + LABEL, anchor="bottom-center")
        self.show(0.0)

    def switch(self, on: bool) -> None:
        """Pale while it is off."""
        for mesh, opacity in self._bodies:
            mesh.opacity = opacity if on else OFF

    def move(self, X_W: Array) -> None:
        """To where its handle has it: (4, 4) from where the scene has it."""
        self._moved = X_W

    def show(self, t: float) -> None:
        """Where it is at t [s]."""
        X = SE3.from_matrix(self._moved @ (np.eye(4) if self._mark.moving is None else self._mark.moving(t)))
        self._frame.wxyz, self._frame.position = X.rotation().wxyz, X.translation()


class FixturePanel:
    """A switch, a weight and a handle for every fixture; each change is one new list for the loop."""

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
        weight = server.gui.add_slider(
            "authority", 0.0, 1.0, 0.05, section.authority, hint=f"How much of {name} counts"
        )
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
    """(4, 4) that takes a fixture along with a handle that began at `middle`, unturned."""
    X = SE3.from_rotation_and_translation(SO3(np.array(handle.wxyz)), np.array(handle.position)).as_matrix()
    X[:3, 3] -= X[:3, :3] @ middle
    return np.asarray(X)


def in_words(tick: Ticks, names: tuple[str, ...]) -> str:
    """What guidance does at a tick: `vessel: 1.20 N; the goal is kept 0.4 mm back`; empty when it does nothing."""
    i = int(tick["guidance_fixture"])
    if not 0 <= i < len(names):
        return ""
    force, moment = (float(np.linalg.norm(tick[key])) for key in ("F_guidance_W", "t_guidance_W"))
    strength = f"{force:.2f} N" if force >= 0.005 else f"{1e3 * moment:.1f} mN m"
    corrected = 1e3 * float(np.linalg.norm(tick["p_correction_W"]))
    rest = f"; the goal is kept {corrected:.1f} mm back" if corrected >= 0.05 else ""
    return f"{names[i]}: {strength}{rest}"
