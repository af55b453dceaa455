# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""Virtual fixtures, and the stage of the haptic cycle that renders them."""

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy
import numpy.typing
from numpy.typing import NDArray

import palpate._core


class Geometry:
    """Geometry of a fixture (core/palpate/guidance/geometry.hpp)."""

    @property
    def solid(self) -> bool:
        """True if the geometry has an inside."""

    @property
    def has_axis(self) -> bool:
        """True if the geometry has an axis; points, balls and clouds have none."""

    def query(
        self,
        X_WT: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
        t: Annotated[NDArray[numpy.float64], "(:,)"],
        exact_within: float = float('inf'),
    ) -> dict[str, Any]:
        """
        Queries for n tool poses X_WT (n, 4, 4) at times t (n,) [s]: a dict with one array of n entries for each field
        of guidance::Query. Beyond exact_within [m] a distance may be a lower bound.
        """

class PointGeometry(Geometry):
    """The point at the origin of its frame."""

    def __init__(self) -> None: ...

class LineGeometry(Geometry):
    """
    A line segment from a to b (3,) [m]; endless: the whole line through them.
    """

    def __init__(
        self,
        a: Annotated[NDArray[numpy.float64], "(3,)"],
        b: Annotated[NDArray[numpy.float64], "(3,)"],
        endless: bool = False,
    ) -> None: ...

class SurfaceGeometry(Geometry):
    """A surface of the scene, in its own frame."""

    def __init__(self, surface: palpate._core.Surface) -> None:
        """surface: a Surface of the scene, such as a Mesh."""

class PathGeometry(Geometry):
    """A curve of cubic Bezier pieces."""

    def __init__(
        self,
        controls: Annotated[NDArray[numpy.float64], "(:, 4, 3)"],
        attitudes: Annotated[NDArray[numpy.float64], "(:, 3, 3)"],
        tangential: bool,
        closed: bool,
    ) -> None:
        """
        controls (n, 4, 3): control points [m]. attitudes (n + 1, 3, 3): rotations at the ends of the pieces.
        tangential: the z axes follow the tangent between these ends. closed: the curve ends where it starts.
        """

    @property
    def length(self) -> float:
        """Length of the curve [m]."""

class ConeGeometry(Geometry):
    """An infinite cone."""

    def __init__(
        self,
        apex: Annotated[NDArray[numpy.float64], "(3,)"],
        axis: Annotated[NDArray[numpy.float64], "(3,)"],
        half_angle: float,
    ) -> None:
        """
        axis (3,): direction from the apex (3,) [m] into the cone; half_angle [rad].
        """

class OffsetGeometry(Geometry):
    """All points within a margin of a geometry."""

    def __init__(self, geometry: Geometry, margin: float) -> None:
        """margin [m]."""

class CombinedGeometry(Geometry):
    """A union, an intersection or a difference of solids."""

    def __init__(
        self,
        kind: Literal['union', 'intersection', 'difference'],
        parts: Sequence[Geometry],
        blend: float = 0.0,
    ) -> None:
        """
        kind: union, intersection, or difference (the first part without the others). blend: difference of two parts'
        distances below which the normal turns gradually from one to the other [m]; 0: it turns at once.
        """

class PlacedGeometry(Geometry):
    """A geometry placed at X_FG (4, 4) in a frame; the default frame is W."""

    def __init__(
        self,
        geometry: Geometry,
        X_FG: Annotated[NDArray[numpy.float64], "(4, 4)"] = ...,
        frame: palpate._core.Frame = ...,
    ) -> None: ...

def guidance_roles() -> list[str]:
    """Names of the available roles."""

def guidance_laws() -> list[str]:
    """Names of the available laws."""

class Fixture:
    """
    Virtual fixture: a geometry, a role, a law and a policy (core/palpate/guidance/fixture.hpp).
    """

    def __init__(
        self,
        name: str,
        geometry: Geometry,
        role: str,
        role_options: palpate._core.GuidanceRoleOptions = ...,
        law: str = 'spring',
        law_options: palpate._core.GuidanceLawOptions = ...,
        policy: palpate._core.Policy = ...,
        on: bool = True,
        timeout: float = float('inf'),
    ) -> None:
        """
        timeout: timeout of the live frames that carry the geometry [s]; without a newer pose the fixture fades out.
        """

    @property
    def name(self) -> str:
        """Name, unique in its list."""

    @property
    def role(self) -> str:
        """Name of the role."""

    @property
    def law(self) -> str:
        """Name of the law."""

    @property
    def policy(self) -> palpate._core.Policy:
        """When and with how much authority the fixture acts."""

    @property
    def on(self) -> bool:
        """False: the fixture is switched off."""

    @property
    def stiffness(self) -> float:
        """Largest stiffness of the law [N/m]."""

    @property
    def damping(self) -> float:
        """Largest damping of the law [N s/m]."""

    @property
    def turning_stiffness(self) -> float:
        """Largest rotational stiffness of the law [N m/rad]."""

    @property
    def turning_damping(self) -> float:
        """Largest rotational damping of the law [N m s/rad]."""

    def evaluate(
        self,
        X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
        t: float = 0.0,
        V_WT: numpy.typing.ArrayLike = ...,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        stiffness: float = 0.0,
    ) -> dict[str, Any]:
        """
        The fixture's constraint on a tool at X_WT (4, 4), as a dict: gap [m, rad], its gradient `along` (6,), its rate
        `drift` caused by the fixture's own motion, the projector `free` (3, 3) on the free directions, attracts, turns
        (the gap is an angle), speed (limit [m/s]). Also the force of the law while the tool moves with V_WT (6,):
        wrench F (6,), stored energy U [J], damping B (3, 3) [N s/m] and the part F_of_B of F that is -B v. Authority
        and other fixtures are not considered.
        """

class Fixtures(palpate._core.FixtureList):
    """An immutable list of fixtures; guidance replaces it as a whole."""

    def __init__(self, fixtures: Sequence[Fixture] = [], tool: palpate._core.LiveFrame | None = None) -> None:
        """
        tool: a frame that receives the tool's pose at every tick, for geometries attached to the tool.
        """

    def __len__(self) -> int: ...

    def list(self) -> list[Fixture]:
        """The fixtures, in order."""

class Guidance:
    """The stage `guidance` outside a loop."""

    def __init__(self, options: palpate._core.GuidanceOptions = ..., dt: float = 0.001) -> None:
        """dt: period of the cycle [s]."""

    def take(self, fixtures: palpate._core.FixtureList) -> None:
        """Replaces the fixtures from the next step on."""

    def step(
        self,
        t: float,
        X_WT_goal: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_WT: numpy.typing.ArrayLike,
        X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
        engaged: bool = True,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        stiffness: float = 0.0,
        F_hand: float = -1.0,
        pedal: float = 1.0,
        takes_damping: bool = False,
    ) -> dict[str, Any]:
        """
        One tick, as a dict: corrected goal X_WT_goal (4, 4), its derivative J_goal (6, 6) with respect to the mapped
        goal, wrench of the fixtures F_T_W (6,) [N, N m], damping B_W (3, 3) [N s/m], index `strongest` of the fixture
        with the largest force (-1: none), its gap [m, rad], correction (3,) of the goal [m], status bits.
        """

    def authority(self, i: int) -> float:
        """Authority of fixture i at the last step, ramps included [-]."""

    def wrench(self, i: int) -> Annotated[NDArray[numpy.float64], "(6,)"]:
        """Wrench of fixture i on the tool at the last step (6,) [N, N m]."""

    def gap(self, i: int) -> float:
        """Gap of fixture i at the last step [m, rad]."""

class Qp:
    """
    Solves min |y - y0|^2 / 2 subject to A y >= b in six variables (core/palpate/guidance/qp.hpp).
    """

    def __init__(self) -> None: ...

    def solve(
        self,
        A: Annotated[NDArray[numpy.float64], "(:, :)"],
        b: numpy.typing.ArrayLike,
        y0: numpy.typing.ArrayLike,
        ranks: Sequence[int] = [],
    ) -> dict[str, Any]:
        """
        Solution as a dict: y (6,), multipliers (m,), status 'solved', 'relaxed' or 'stopped', gave_way (m,) for rows
        that were relaxed, number of steps, and the index of each row (negative: rejected).
        """

def run_guidance(
    stage: Guidance,
    t: Sequence[float],
    X_WT_goal: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
    V_WT: Annotated[NDArray[numpy.float64], "(:, 6)"],
    X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
    normal: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    height: Sequence[float] = [],
    stiffness: float = 0.0,
    F_hand: float = -1.0,
    pedal: float = 1.0,
    takes_damping: bool = False,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Runs a Guidance along a motion: times t (n,) [s], goals X_WT_goal (n, 4, 4), twists V_WT (n, 6). The measured tool
    pose is the previous goal, at first X_WT (4, 4). Below the plane normal . p = height (n,) the tool touches a spring
    of the given stiffness [N/m]. Returns F_T_W (n, 6), X_WT_goal (n, 16), B_W (n, 9) and gap (n,).
    """
