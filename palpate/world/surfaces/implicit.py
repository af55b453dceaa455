"""The implicit surface of the paper's Eqs 14-16."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import SurfaceError
from palpate.world.surfaces.surface import Surface, Triangles, three


class ImplicitSurface(Surface):
    """{x : a x^m + b y^n + c z^o = level} (Eq 14), with grad U as normal (Eqs 15, 16).

    Args:
        coefficients: (a, b, c), positive, [1/m^exponent]: 1 / (half length)^exponent for level 1.
        exponents: (m, n, o), even, 2 to 12.
        level: positive [-].
        name: name in plots and messages.

    Raises:
        SurfaceError: the values do not give a closed convex surface.
    """

    core: _core.ImplicitSurface

    def __init__(
        self,
        coefficients: npt.ArrayLike,
        exponents: Sequence[int] = (2, 2, 2),
        level: float = 1.0,
        *,
        name: str = "implicit",
    ) -> None:
        abc = three("coefficients of an implicit surface", coefficients)
        m, n, o = (int(e) for e in three("exponents of an implicit surface", exponents))
        self.name, self.coefficients, self.exponents, self.level = name, abc, (m, n, o), float(level)
        try:
            self.core = _core.ImplicitSurface(abc, [m, n, o], self.level)
        except ValueError as error:
            raise SurfaceError(
                str(error), mend="give even exponents of 2 to 12, positive coefficients and level"
            ) from None

    @classmethod
    def of_half_lengths(
        cls, half: npt.ArrayLike, exponents: Sequence[int] = (2, 2, 2), *, name: str = "implicit"
    ) -> ImplicitSurface:
        """The surface with half lengths ``half`` (3,) [m]: sum (x_i / half_i)^m_i = 1."""
        lengths = three("half lengths of an implicit surface", half)
        if (lengths <= 0).any():
            raise SurfaceError(
                f"half lengths must be positive, got {lengths.tolist()}", mend="give one for each axis [m]"
            )
        return cls(lengths ** -np.asarray(exponents, dtype=float), exponents, name=name)

    def value(self, point: npt.ArrayLike) -> float:
        """U(point) - level (Eq 14); negative inside."""
        return self.core.value(three("point", point))

    def gradient(self, point: npt.ArrayLike) -> Array:
        """grad U at a point (3,) (Eq 15) [1/m]."""
        return self.core.gradient(three("point", point))

    def __str__(self) -> str:
        """Its equation with half lengths in millimetres."""
        terms = " + ".join(
            f"({x}/{1e3 * h:g})^{e}" for x, h, e in zip("xyz", self.core.half, self.exponents, strict=True)
        )
        return f"{terms} = 1, in mm"

    def _drawing(self) -> tuple[Array, Triangles]:
        """A geodesic sphere whose vertices are moved along their rays to U = level."""
        from palpate.world.shapes import analytic

        rays, triangles = analytic.Sphere(1.0).mesh(20_000)
        low, high = np.zeros((len(rays), 1)), np.full((len(rays), 1), 2.0)
        for _ in range(55):  # bisection, to rounding
            middle = 0.5 * (low + high)
            outside = ((middle * rays) ** self.exponents).sum(axis=1, keepdims=True) > 1.0
            low, high = np.where(outside, low, middle), np.where(outside, middle, high)
        return low * rays * self.core.half, triangles
