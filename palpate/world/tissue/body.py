"""A soft body that one can touch: a mesh of tetrahedra with its material, accepted by ``palpate.contact.render``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import SurfaceError
from palpate.world.surfaces import Surface
from palpate.world.tissue.bounds import PERIOD

if TYPE_CHECKING:
    from palpate import _tissue

Indices = npt.NDArray[np.int32]

MOST_IN_CYCLE = 16e6
"""Largest number of tetrahedra over the time step of a body that steps in the haptic cycle [1/s]: about a third of a
1 ms cycle, by ``palpate bench tissue``."""


class Tetrahedra(Protocol):
    """A mesh of tetrahedra."""

    @property
    def nodes(self) -> Array:
        """(n, 3) positions [m]."""

    @property
    def tets(self) -> Indices:
        """(m, 4) indices of nodes."""

    @property
    def surface(self) -> Indices:
        """(k, 3) indices of nodes, wound outwards."""


class Tissue(Surface):
    """Soft tissue as explicit finite elements.

    The material is Neo-Hookean with a stiffening term and Prony terms; ``_tissue.TissueBody`` states its energy. One
    value holds for the whole body; an array (m,) gives one per tetrahedron.

    Args:
        mesh: tetrahedra, or (nodes (n, 3) [m], tets (m, 4)).
        young: Young's modulus after full relaxation [Pa].
        poisson: Poisson's ratio, 0 <= nu < 0.5.
        density: [kg/m^3].
        yeoh: stiffening coefficient c [-].
        prony: pairs (g [-], tau [s]), at most four; the shear modulus at once is that at rest times (1 + sum g), up to
            101 times. The bulk modulus does not relax. tau from 1e-5 to 1000 s.
        fixed: nodes that do not move: flags (n,) or indices. None: no node, the body floats.
        spring: stiffness of springs from the nodes to their rest positions, one number or (n,) [N/m].
        damping: damping force per mass and velocity [1/s].
        step: time step; 0: the longest that needs little added mass [s].
        portable: use the kernels without AVX2, for comparison.
        thread: where it steps: "cycle", every tick in the haptic cycle; "own", on a thread of its own; "auto": by the
            number of tetrahedra and steps.
        period: of a thread of its own, which steps so long at once, up to 0.05 [s].
        name: name in plots and messages.

    Raises:
        SurfaceError: a value is not valid; the message names it.
    """

    def __init__(
        self,
        mesh: Tetrahedra | tuple[npt.ArrayLike, npt.ArrayLike],
        *,
        young: float | npt.ArrayLike,
        poisson: float | npt.ArrayLike = 0.45,
        density: float | npt.ArrayLike = 1000.0,
        yeoh: float | npt.ArrayLike = 0.0,
        prony: Sequence[tuple[float, float]] = (),
        fixed: npt.ArrayLike | None = None,
        spring: float | npt.ArrayLike = 0.0,
        damping: float = 5.0,
        step: float = 0.0,
        portable: bool = False,
        thread: str = "auto",
        period: float = PERIOD,
        name: str = "tissue",
    ) -> None:
        from palpate import _tissue

        self.name = name
        nodes, self.tets, self.surface = _parts(mesh)
        self.nodes = nodes
        m, n = len(self.tets), len(nodes)
        E, nu = _each("young", young, m), _each("poisson", poisson, m)
        self.poisson = float(nu.max())
        if not ((E > 0) & np.isfinite(E)).all():
            raise SurfaceError(f"young = {E.min():g} Pa must be above 0", mend="for example 5000 for liver")
        if not ((nu >= 0) & (nu < 0.5)).all():
            worst = float(nu[~((nu >= 0) & (nu < 0.5))][0])
            raise SurfaceError(f"poisson = {worst:g} must lie in 0 <= nu < 0.5", mend="0.45 to 0.49 for soft tissue")
        try:
            self.body = _tissue.TissueBody(
                nodes=nodes,
                tets=self.tets,
                surface=self.surface,
                mu=E / (2.0 * (1.0 + nu)),
                bulk=E / (3.0 * (1.0 - 2.0 * nu)),
                density=_each("density", density, m),
                yeoh=_each("yeoh", yeoh, m),
                prony=[(float(g), float(tau)) for g, tau in prony],
                fixed=_flags(fixed, n),
                spring=_each("spring", spring, n),
                damping=float(damping),
                step=float(step),
                portable=portable,
            )
        except ValueError as error:
            raise SurfaceError(str(error), mend="correct the value or the mesh") from None
        self.period = _period(thread, period, len(self.tets) / self.body.time_step)

    @cached_property
    def core(self) -> _tissue.TissueSurface:  # type: ignore[override]
        """The C++ surface."""
        from palpate import _tissue

        return _tissue.TissueSurface(self.body, 0.0, self.period)

    def __str__(self) -> str:
        """Number of tetrahedra and time step."""
        added = 100.0 * self.body.added_mass()
        return f"{len(self.tets)} tetrahedra, step {1e3 * self.body.time_step:g} ms, added mass {added:.1f} %"

    def _drawing(self) -> tuple[Array, Indices]:
        return self.nodes, self.surface


def _period(thread: str, period: float, load: float) -> float:
    """Period of the thread that steps a body [s]; 0: it steps in the cycle. load: tetrahedra over the time step [1/s].

    Raises:
        SurfaceError: the thread is not known, or the period is not possible.
    """
    if thread not in ("auto", "cycle", "own"):
        raise SurfaceError(f"thread = {thread!r} is not known", mend="use auto, cycle or own")
    if not 0.0 < period <= 0.05:
        raise SurfaceError(f"period = {period:g} s must be above 0 and at most 0.05", mend="for example 0.004")
    return period if thread == "own" or (thread == "auto" and load > MOST_IN_CYCLE) else 0.0


def boundary(tets: Indices) -> Indices:
    """Triangles (k, 3) that belong to only one of the tetrahedra (m, 4) of positive volume, wound outwards."""
    faces = np.concatenate([tets[:, f] for f in ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3])])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return np.ascontiguousarray(faces[first[count == 1]], dtype=np.int32)


def _parts(mesh: Tetrahedra | tuple[npt.ArrayLike, npt.ArrayLike]) -> tuple[Array, Indices, Indices]:
    """Nodes, tetrahedra and surface."""
    if isinstance(mesh, tuple):
        nodes = np.ascontiguousarray(mesh[0], dtype=np.float64)
        tets = np.ascontiguousarray(mesh[1], dtype=np.int32)
        if nodes.ndim != 2 or nodes.shape[1] != 3 or tets.ndim != 2 or tets.shape[1] != 4:
            what = f"mesh must be nodes (n, 3) and tetrahedra (m, 4), got {nodes.shape} and {tets.shape}"
            raise SurfaceError(what, mend="give positions in metres and indices of nodes")
        return nodes, tets, boundary(tets)
    return (
        np.ascontiguousarray(mesh.nodes, dtype=np.float64),
        np.ascontiguousarray(mesh.tets, dtype=np.int32),
        np.ascontiguousarray(mesh.surface, dtype=np.int32),
    )


def _each(name: str, value: float | npt.ArrayLike, n: int) -> Array:
    values = np.asarray(value, dtype=np.float64)
    if values.shape not in ((), (n,)):
        raise SurfaceError(f"{name} must be one number or {n}, got shape {values.shape}", mend="one number is enough")
    return np.ascontiguousarray(np.broadcast_to(values, (n,)))


def _flags(fixed: npt.ArrayLike | None, n: int) -> npt.NDArray[np.bool_]:
    out = np.zeros(n, dtype=bool)
    if fixed is not None:
        chosen = np.asarray(fixed)
        if chosen.dtype == bool and chosen.shape != (n,):
            raise SurfaceError(
                f"fixed must have one flag for each of the {n} nodes, got {chosen.shape}", mend="see mesh"
            )
        if chosen.size:
            try:
                out[chosen] = True
            except IndexError as error:
                raise SurfaceError(f"fixed: {error}", mend=f"indices from 0 to {n - 1}") from None
    return out
