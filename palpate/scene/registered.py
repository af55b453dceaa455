"""The organ of a scene's section `registration`, and the scene with its registered frame at a given pose."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse, transform
from palpate.base.errors import SceneError
from palpate.scene import surface
from palpate.scene.registration import RegistrationSection
from palpate.scene.scene import Scene
from palpate.world.frames import FrameSection
from palpate.world.registration.clouds import sampled
from palpate.world.registration.procedure import Organ

_SAMPLES = 20_000  # points spread over the organ


def section(scene: Scene) -> RegistrationSection:
    """The scene's section `registration`.

    Raises:
        SceneError: the scene has none.
    """
    if scene.registration is None:
        mend = "give registration: {frame: anatomy, targets: {...}, camera: {...}} (docs/registration-session.md)"
        raise SceneError("the scene has no section registration", where=scene.file, mend=mend)
    return scene.registration


def entry(scene: Scene) -> FrameSection:
    """The entry of `frames` that places the registered frame.

    Raises:
        SceneError: there is none, it has no file, or its parent is not the world.
    """
    name, where = section(scene).frame, scene.where("registration", "frame")
    found = next((one for one in scene.frames if one.child == name and not one.check), None)
    mend = f"give frames the entry {{child: {name}, file: registered.yaml}}"
    if found is None or found.file is None:
        what = (
            f"there is no frame {name!r} to register" if found is None else f"frame {name!r} is placed without a file"
        )
        raise SceneError(what, where=where, mend=mend)
    if found.parent != "world":
        raise SceneError(f"the parent of frame {name!r} is {found.parent!r}", where=where,
                         why="organs are registered in the world", mend=mend)  # fmt: skip
    return found


def view_file(scene: Scene, last: bool = False) -> Path | None:
    """File with the points that the camera sees before the touches, or after the `last` one; None: simulated.

    Raises:
        SceneError: the scene has no camera, or the path contains an unset variable.
    """
    camera = section(scene).camera
    if camera is None:
        raise SceneError("the scene has no camera", where=scene.file, mend="give registration.camera")
    file = camera.cloud_after if last else camera.cloud
    return None if file is None else scene.path_to(file, where=scene.where("registration", "camera"))


def file_of(scene: Scene) -> Path:
    """Path of the file with the registered pose, which need not exist yet.

    Raises:
        SceneError: as for `entry`.
    """
    found = entry(scene)
    return scene.path_to(str(found.file), where=scene.where("registration", "frame"))


def at(scene: Scene, X_WA: Array) -> Scene:
    """The scene with its registered frame at the pose X_WA (4, 4) in W, instead of the pose of its file [m].

    Raises:
        SceneError: as for `entry`.
    """
    name = entry(scene).child
    fixed = FrameSection.model_validate({"child": name, "pose": {"matrix": X_WA.tolist()}, "source": "registration"})
    frames = tuple(fixed if one.child == name and not one.check else one for one in scene.frames)
    return scene.model_copy(update={"frames": frames}).with_file_of(scene)


class RegisteredOrgan:
    """The organ to register, in its own frame O, with the scene's names.

    Raises:
        SceneError, MeshError: the section or its object is missing, or the surface cannot be read.
        RegistrationError: a target lies outside of the organ, or a landmark away from its surface.
    """

    def __init__(self, scene: Scene) -> None:
        self.section = section(scene)
        placed = surface.placed(at(scene, np.eye(4)))
        self.index = _index(scene, self.section)
        body = placed[self.index].body
        self.X_AO = scene.objects[self.index].pose.matrix()  #: pose (4, 4) of the organ in the registered frame A
        X_OA = inverse(self.X_AO)
        vertices, triangles = np.asarray(body.vertices), np.asarray(body.triangles)
        targets = {name: transform(X_OA, np.array([p]))[0] for name, p in self.section.targets.items()}
        self.landmarks = {name: transform(X_OA, np.array([p]))[0] for name, p in self.section.landmarks.items()}
        self.organ = Organ(body.core, sampled(vertices, triangles, _SAMPLES), targets)
        self.organ.check_targets()
        self.organ.check_landmarks(self.landmarks)


def _index(scene: Scene, given: RegistrationSection) -> int:
    inside = [i for i, one in enumerate(scene.objects) if one.frame == given.frame]
    named = [i for i in inside if not given.object or scene.objects[i].name == given.object]
    if not named:
        what = f"no object {given.object!r} stands in frame {given.frame!r}".replace(" ''", "")
        mend = f"give the organ the key frame: {given.frame}"
        raise SceneError(what, where=scene.where("registration", "object"), mend=mend)
    return named[0]
