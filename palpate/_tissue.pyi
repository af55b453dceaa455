# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
Surfaces that deform or come from a sensor: soft bodies and point clouds.
"""

from collections.abc import Sequence
from typing import Annotated, Any, Final, overload

import numpy
from numpy.typing import NDArray

import palpate._core


class PointSurface(palpate._core.Surface):
    """The surface through a point cloud (algebraic spheres)."""

    def __init__(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
        normals: Annotated[NDArray[numpy.float64], "(:, 3)"] | None = None,
        viewpoint: Annotated[NDArray[numpy.float64], "(3,)"] | None = None,
        voxel: float = 0.001,
        support: float = 0.006,
        bridge: float = 0.003,
        thickness: float = 0.02,
        continues: PointSurface | None = None,
    ) -> None:
        """
        points (n, 3) [m]; normals (n, 3), zero where unknown; viewpoint (3,): position of the sensor, which orients
        unknown normals [m]; voxel, support, bridge, thickness [m]; continues: surface of the previous frame.
        """

    def averaged(self) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]:
        """Averaged points: positions (n, 3) [m], normals (n, 3), weights (n,)."""

    def shift_to(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
        centre: Annotated[NDArray[numpy.float64], "(3,)"],
        radius: float,
    ) -> Annotated[NDArray[numpy.float64], "(3,)"] | None:
        """
        Displacement (3,) [m] by which the surface moved to pass through the points (n, 3) within radius [m] of centre
        (3,) [m]; None if it cannot be determined.
        """

    def translate(self, d: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """Moves the surface by d (3,) [m]; only before it is handed to a loop."""

    @property
    def id(self) -> int:
        """Number of the stream of surfaces."""

    @property
    def rejected(self) -> int:
        """Number of averaged points left out as flying pixels."""

    def __len__(self) -> int:
        """Number of averaged points."""

@overload
def usable_points(
    points_C: Annotated[NDArray[numpy.float32], "(:, 3)"],
    X_WC: Annotated[NDArray[numpy.float64], "(4, 4)"],
    centre: Annotated[NDArray[numpy.float64], "(3,)"],
    radius: float,
    tool: Annotated[NDArray[numpy.float64], "(:, 4)"],
) -> tuple[NDArray[numpy.float64], dict[str, Any]]: ...

@overload
def usable_points(
    points_C: Annotated[NDArray[numpy.float64], "(:, 3)"],
    X_WC: Annotated[NDArray[numpy.float64], "(4, 4)"],
    centre: Annotated[NDArray[numpy.float64], "(3,)"],
    radius: float,
    tool: Annotated[NDArray[numpy.float64], "(:, 4)"],
) -> tuple[NDArray[numpy.float64], dict[str, Any]]:
    """
    (points (n, 3) in W [m], counts) of a frame (m, 3) of float or double in the camera's frame [m]: those that are
    finite, within radius [m] of centre (3,) in W, and outside the balls tool (k, 4) in W, centre and radius [m].
    counts: used, invalid, outside, tool.
    """

YEOH_GROWTH: float = 0.18

class TissueBody:
    """
    A soft body of linear tetrahedra, stepped explicitly; all in the object's frame O. Energy per volume: mu/2 (w + c
    max(w, 0)^2) + k/2 (J - 1)^2 with w = I1 - 3 - 2 (J - 1), I1 = tr F^T F, J = det F and k = bulk + mu/3: a stable
    Neo-Hookean solid (after Smith, de Goes and Kim 2018) with the stiffening of Yeoh (1993), and a barrier 4 k/2 min(J
    - .3, 0)^2 against inversion. Prony terms g add the energy g mu/2 |Z - q|^2, q' = (Z - q) / tau, of a strain Z
    without change of volume: mu/2 |Z|^2 = mu/2 (w + c w^2) with w = J^(-2/3) I1 - 3.
    """

    def __init__(
        self,
        *,
        nodes: Annotated[NDArray[numpy.float64], "(:, 3)"],
        tets: Annotated[NDArray[numpy.int32], "(:, 4)"],
        surface: Annotated[NDArray[numpy.int32], "(:, 3)"],
        mu: Annotated[NDArray[numpy.float64], "(:,)"],
        bulk: Annotated[NDArray[numpy.float64], "(:,)"],
        density: Annotated[NDArray[numpy.float64], "(:,)"],
        yeoh: Annotated[NDArray[numpy.float64], "(:,)"],
        prony: Sequence[tuple[float, float]],
        fixed: Annotated[NDArray[numpy.bool_], "(:,)"],
        spring: Annotated[NDArray[numpy.float64], "(:,)"],
        step: float = 0.0,
        tick: float = 0.001,
        damping: float = 5.0,
        mass_limit: float = 0.05,
        portable: bool = False,
    ) -> None:
        """
        nodes (n, 3) [m]; tets (m, 4), surface (k, 3) with outward winding: int32 indices of nodes; mu, bulk (m,) [Pa]:
        shear modulus after full relaxation and bulk modulus; density (m,) [kg/m^3]; yeoh (m,): c [-]; prony: pairs (g
        [-], tau [s]), sum of g up to 100, tau from 1e-5 to 1000, instantaneous modulus mu (1 + sum g); fixed (n,) bool;
        spring (n,) [N/m] to the rest positions; step [s], 0: chosen so that the added mass stays below mass_limit [-];
        tick: period of the loop [s]; damping: force per mass and velocity [1/s]. Raises ValueError naming the invalid
        value.
        """

    def step(self, n: int = 1) -> None:
        """Advances by n time steps."""

    def reset(self) -> None:
        """Returns to rest."""

    def set_loads(self, forces: Annotated[NDArray[numpy.float64], "(:, 3)"]) -> None:
        """Sets the forces on the nodes (n, 3) [N]."""

    def set_state(
        self,
        positions: Annotated[NDArray[numpy.float64], "(:, 3)"],
        velocities: Annotated[NDArray[numpy.float64], "(:, 3)"],
    ) -> None:
        """Sets positions (n, 3) [m] and velocities (n, 3) [m/s]."""

    def positions(self) -> NDArray[numpy.float64]:
        """Positions of the nodes (n, 3) [m]."""

    def velocities(self) -> NDArray[numpy.float64]:
        """Velocities of the nodes (n, 3) [m/s]."""

    def internal_forces(self) -> NDArray[numpy.float64]:
        """
        Elastic forces on the nodes at the present positions, without Prony terms and springs (n, 3) [N].
        """

    def masses(self) -> NDArray[numpy.float64]:
        """Masses of the nodes, added mass included (n,) [kg]."""

    def energies(self) -> tuple[float, float]:
        """
        (potential, kinetic) [J]; the potential is that at the beginning of the last step.
        """

    def layers(self) -> NDArray[numpy.int32]:
        """
        Layers of nodes below the free surface near each node, at most 4 (n,): 0 where the body is one tetrahedron
        thick, 1 for two or three.
        """

    def stable_step(self) -> float:
        """Longest stable step without added mass: a bound, at rest [s]."""

    def added_mass(self) -> float:
        """Mass added for the time step, as a share of the mass [-]."""

    @property
    def time_step(self) -> float:
        """Time step [s]."""

    @property
    def steps_per_tick(self) -> int:
        """Steps in a period of the loop."""

    @property
    def least_volume(self) -> float:
        """
        Smallest det F at the beginning of the last step; zero or less: inverted [-].
        """

    has_avx2: Final[bool] = ...
    """True if the AVX2 kernels are used."""

class TissueSurface(palpate._core.Surface):
    """
    The surface of a soft body, for contact. Each loop and each rendering uses a copy at rest.
    """

    def __init__(
        self,
        body: TissueBody,
        width: float = 0.0,
        period: float = 0.0,
        like: TissueSurface | None = None,
    ) -> None:
        """
        body: gives the mesh, the material and the step; its state is not used. width: standard deviation of the spread
        contact force [m], 0: .7 of the mean edge. period: by which the body steps beside the cycle [s]; 0: in every
        tick. like: another surface of the same body, which fixtures know. Raises ValueError if the body has no surface
        or the period is not from 0 to 0.05 s.
        """

    @property
    def edge(self) -> float:
        """Mean length of the edges of the surface [m]."""

    @property
    def width(self) -> float:
        """Standard deviation of the spread contact force [m]."""

    @property
    def period(self) -> float:
        """Period of the steps beside the cycle [s]; 0: in every tick."""

    def set_patient(self, patient: bool) -> None:
        """
        True: a loop that runs more than twice as fast as real time waits for the thread beside it. Copies at rest
        inherit it.
        """

    @property
    def vertices(self) -> NDArray[numpy.float64]:
        """Vertices of the surface at rest (n, 3), in O [m]."""

    @property
    def triangles(self) -> NDArray[numpy.int32]:
        """Triangles of the surface (m, 3), wound outwards."""

    def own(self) -> TissueSurface:
        """A copy at rest, as each loop makes one."""

    def advance(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        depth: float,
        radius: float,
        force: Annotated[NDArray[numpy.float64], "(3,)"],
        dt: float = 0.001,
    ) -> None:
        """
        Advances a loop's copy by a tick under the contact of one sphere. p: contact point (3,) [m]; normal: unit (3,),
        outwards; depth, radius [m]; force on the tool (3,) [N]; all in O.
        """

    def respond(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        depth: float,
        radius: float,
    ) -> float:
        """Normal force on a sphere [N]."""

    def near_field(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        depth: float,
        radius: float,
    ) -> tuple[float, float, float]:
        """
        (force [N], its derivative by the depth [N/m], energy [J]) of the near field.
        """

    def set_beside(self, beside: bool) -> None:
        """True: work() steps the body, not advance()."""

    def work(self) -> bool:
        """Steps the body by a period if it is due. Returns True if it was."""

    def set_state(
        self,
        displacements: Annotated[NDArray[numpy.float64], "(:, 3)"],
        velocities: Annotated[NDArray[numpy.float64], "(:, 3)"],
    ) -> None:
        """
        Sets displacements (n, 3) [m] and velocities (n, 3) [m/s] of all nodes, for tests of the guard.
        """

    def state(self) -> tuple[float, float, bool, bool, bool]:
        """
        (potential [J], kinetic [J], hurried, frozen, late), as in the signal tissue_status.
        """

class SharedTissue(palpate._core.Surface):
    """The surface of a soft body that loops share."""

    @property
    def vertices(self) -> NDArray[numpy.float64]:
        """Vertices of the surface at rest (n, 3), in O [m]."""

    @property
    def triangles(self) -> NDArray[numpy.int32]:
        """Triangles of the surface (m, 3), wound outwards."""

    def displacements(self) -> NDArray[numpy.float64]:
        """Displacements of the nodes of the body (n, 3) [m]."""

def share_bodies(snapshot: palpate._core.Snapshot) -> palpate._core.Snapshot:
    """
    The snapshot with soft bodies that all its loops share: one body each, which the tools of all loops press in the
    cycle.
    """
