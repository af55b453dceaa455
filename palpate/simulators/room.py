"""A simulated operating room for the registration of an organ: its true pose, a depth camera, and a touching hand."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, inverse
from palpate.base.errors import SceneError
from palpate.scene.registered import at, section, view_file
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.simulators.depth_camera import DepthCamera
from palpate.simulators.touching_hand import TouchingHand
from palpate.world.registration.cloud_files import read_cloud


class Room:
    """The truth of a scene's section `registration`: where the organ, the camera and the tool's tip really are.

    The camera's true pose and the error of the tip's offset are drawn from the uncertainties that the scene states.

    Args:
        scene: scene with a section `registration` that has `simulated`.
        seed: seed of all errors; the scene's when None.
        tip_error: additional error of the tip's calibrated offset (3,) in the tool's frame [m].

    Raises:
        SceneError: the section is missing, or the scene cannot be set up at the true pose.
    """

    def __init__(self, scene: Scene, seed: int | None = None, tip_error: Array | None = None) -> None:
        found = section(scene)
        if found.simulated is None:
            what = "the scene states no true pose, so that its registration cannot be simulated"
            raise SceneError(what, where=scene.file, mend="give registration.simulated.pose, or register attended")
        self.section, self.seed = found, scene.seed if seed is None else seed
        self.X_WA = found.simulated.pose.matrix()  #: true pose (4, 4) of the registered frame
        rng = np.random.default_rng([self.seed, 1])
        self._rng, self._scene = rng, scene
        self.rig = build(at(scene, self.X_WA))
        self._departure = rng.normal(size=6)  # of the camera from its stated pose, in standard deviations
        self._tip = 1e-3 * found.tip_mm * rng.normal(size=3) + (0.0 if tip_error is None else tip_error)
        self.hand = TouchingHand(self.rig, 1e-3 * found.touch_mm, self._tip, self.seed)

    def move(self, X_WA: Array) -> None:
        """Move the organ to the pose X_WA (4, 4), as a patient who is pushed [m]."""
        self.X_WA = X_WA
        self.rig = build(at(self._scene, X_WA))
        self.hand = TouchingHand(self.rig, 1e-3 * self.section.touch_mm, self._tip, self.seed + 1)

    def look(self, index: int, last: bool = False) -> Array:
        """Points (N, 3) of the object `index` in the camera's frame, simulated or from the scene's files [m].

        Args:
            index: the object.
            last: after the last touch, which has a file of its own.
        """
        file, camera = view_file(self._scene, last), self.section.camera
        if file is not None:
            return read_cloud(file)
        assert camera is not None
        stated = self.rig.frames.pose(camera.frame)
        variances, axes = np.linalg.eigh(stated.covariance)
        X_WC = displaced(stated.X, axes @ (np.sqrt(np.maximum(variances, 0.0)) * self._departure))
        seen = DepthCamera(noise=1e-3 * camera.noise_mm, outliers=camera.outliers)
        placed = self.rig.surfaces[index]
        return seen.look(placed.body.core, inverse(X_WC) @ placed.X_WO, self._rng)
