"""Draws triangles with the light of an endoscope, by OpenGL without a window (moderngl; Mesa where there is no GPU)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError, PalpateError

Image = NDArray[np.uint8]
_NEAR, _FAR = 0.004, 1.0  # [m]
_BACKGROUND = (0.16, 0.06, 0.05)  # of the cavity
_KEPT = 2  # backgrounds: one for each eye

_VERTEX = """
#version 330
in vec3 point; in vec3 normal;
uniform mat4 to_camera; uniform mat4 to_picture;
out vec3 at; out vec3 up;
void main() {
  vec4 p = to_camera * vec4(point, 1.0);
  at = p.xyz; up = mat3(to_camera) * normal;
  gl_Position = to_picture * p;
}
"""
_FRAGMENT = """
#version 330
in vec3 at; in vec3 up;
uniform vec3 color; uniform float gloss;
out vec4 shown;
void main() {
  vec3 n = normalize(up), to_eye = normalize(-at);
  float facing = abs(dot(n, to_eye));
  float fall = clamp(0.09 / length(at), 0.35, 1.6);
  shown = vec4(color * (0.12 + 0.88 * facing) * fall + gloss * pow(facing, 40.0), 1.0);
}
"""


class Body:
    """Triangles of one colour that move as a whole, or whose vertices are replaced."""

    def __init__(self, context: Any, program: Any, points: Array, triangles: NDArray[Any], color: Any, gloss: float):
        self._triangles = np.asarray(triangles, dtype=np.int32)
        self._buffer = context.buffer(reserve=24 * len(points), dynamic=True)
        index = context.buffer(self._triangles.tobytes())
        self._array = context.vertex_array(program, [(self._buffer, "3f 3f", "point", "normal")], index)
        self._program, self._color, self._gloss = program, tuple(c / 255.0 for c in color), gloss
        self.X_WB = np.eye(4)
        """Pose (4, 4) in W [m]."""
        self.replace(points)

    def replace(self, points: Array) -> None:
        """Replace the vertices (n, 3) [m]."""
        data = np.concatenate([points, _normals(points, self._triangles)], axis=1)
        self._buffer.write(np.ascontiguousarray(data, dtype=np.float32).tobytes())

    def draw(self, X_CW: Array) -> None:
        """Draw the body for a camera with the inverse pose X_CW (4, 4)."""
        _set(self._program, "to_camera", X_CW @ self.X_WB)
        self._program["color"].value = self._color
        self._program["gloss"].value = self._gloss
        self._array.render()


class Canvas:
    """Pictures of a size (height, width) with a horizontal angle of view [deg].

    Raises:
        MissingExtraError: moderngl is not installed. PalpateError: the machine has no OpenGL without a window.
    """

    def __init__(self, size: tuple[int, int], width_deg: float) -> None:
        try:
            import moderngl
        except ImportError:
            raise MissingExtraError("moderngl, which draws the video,", "learning") from None
        try:
            settings: dict[str, Any] = {"backend": "egl"}
            self._context: Any = moderngl.create_standalone_context(**settings)
        except Exception as error:  # moderngl raises Exception itself
            mend = "install EGL with a driver, e.g. apt install libegl1 libgl1-mesa-dri; or leave --video out"
            raise PalpateError("no OpenGL without a window", why=str(error).splitlines()[0], mend=mend) from None
        self._context.enable(moderngl.DEPTH_TEST)
        self._program: Any = self._context.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT)
        _set(self._program, "to_picture", _projection(size, width_deg))
        self._size = size
        self._frame = self._buffer()
        self._bodies: list[Body] = []
        self._resting: list[Body] = []
        self._backgrounds: dict[bytes, Any] = {}
        """What cameras saw of the bodies at rest, by their pose: colours and depths; the newest comes last."""

    @property
    def renderer(self) -> str:
        """Name of what draws, such as llvmpipe."""
        return str(self._context.info["GL_RENDERER"])

    def add(
        self, points: Array, triangles: NDArray[Any], color: Any, gloss: float = 0.15, X_WB: Array | None = None
    ) -> Body:
        """A body with vertices (n, 3) [m] in its own axes, and a colour of 0 to 255.

        One with a pose X_WB (4, 4) rests there and keeps its vertices: a camera that stays draws it once.
        """
        body = Body(self._context, self._program, points, triangles, color, gloss)
        if X_WB is None:
            self._bodies.append(body)
        else:
            body.X_WB = X_WB
            self._resting.append(body)
            self._backgrounds.clear()
        return body

    def picture(self, X_WC: Array) -> Image:
        """What a camera at X_WC (4, 4) sees, x right and y down: (h, w, 3)."""
        X_CW = np.asarray(np.linalg.inv(X_WC), dtype=np.float64)
        self._context.copy_framebuffer(self._frame, self._background(X_CW))
        self._frame.use()
        for body in self._bodies:
            body.draw(X_CW)
        return np.frombuffer(self._frame.read(components=3, alignment=1), np.uint8).reshape(*self._size, 3)

    def _background(self, X_CW: Array) -> Any:
        """The bodies at rest, seen by a camera with the inverse pose X_CW (4, 4)."""
        key = X_CW.tobytes()
        if key not in self._backgrounds:
            oldest = next(iter(self._backgrounds)) if len(self._backgrounds) >= _KEPT else None
            frame = self._buffer() if oldest is None else self._backgrounds.pop(oldest)
            frame.use()
            self._context.clear(*_BACKGROUND)
            for body in self._resting:
                body.draw(X_CW)
            self._backgrounds[key] = frame
        return self._backgrounds[key]

    def _buffer(self) -> Any:
        """A place to draw to, with colours and depths."""
        wide = (self._size[1], self._size[0])
        return self._context.framebuffer([self._context.texture(wide, 4)], self._context.depth_renderbuffer(wide))

    def close(self) -> None:
        """Release the pictures and bodies."""
        self._context.release()


def _projection(size: tuple[int, int], width_deg: float) -> Array:
    """Projection of camera axes (y down, z ahead) whose first row in memory is the top of the picture."""
    f = 1.0 / np.tan(0.5 * np.radians(width_deg))
    P = np.zeros((4, 4))
    P[0, 0], P[1, 1] = f, f * size[1] / size[0]
    P[2, 2], P[2, 3] = (_FAR + _NEAR) / (_FAR - _NEAR), -2.0 * _FAR * _NEAR / (_FAR - _NEAR)
    P[3, 2] = 1.0
    return P


def _set(program: Any, name: str, M: Array) -> None:
    """Set a matrix (4, 4) of a program."""
    program[name].write(np.ascontiguousarray(M.T, dtype=np.float32).tobytes())


def _normals(points: Array, triangles: NDArray[np.int32]) -> Array:
    """Normals (n, 3) of vertices: those of their triangles, weighed by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    total = np.stack([
        np.bincount(triangles.ravel(), np.repeat(face[:, k], 3), len(points)) for k in range(3)
    ], axis=1)  # fmt: skip
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / np.maximum(length, 1e-12))
