"""The engine of the rigid bodies: MuJoCo's model of a scene, and its arrays as the core takes them.

The core calls `mj_step` through a pointer and reads and writes MuJoCo's arrays; nothing of it passes through Python
while a loop runs. Every tool has a virtual tool: a light free body at T with two driven jaws. Shaft and wrist are
bodies of their own, since they turn against the tool.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import quaternions
from palpate.base.errors import MissingExtraError, SceneError
from palpate.world.bodies.sections import BodySection, EngineSection, numbers
from palpate.world.bodies.shapes import Primitive, solids, spheres

TOOL_MASS = 0.01
"""Mass of a virtual tool, which the hand feels in addition to its arm [kg]."""
_TOOL_INERTIA = 1e-5  # of a virtual tool [kg m^2]
_JAW_MASS = 0.0005  # [kg]
_JAW_INERTIA = 5e-6  # of a jaw's drive [kg m^2]
_JAW_STIFFNESS = 0.6  # of a jaw's drive [N m/rad]
_JAW_DAMPING = 0.003  # [N m s/rad]
_JAW_WIDTH = 0.0017  # half the width of a jaw's face [m]
_SOLID = {"solref": "0.01 1", "solimp": "0.95 0.99 0.0005"}  # contact: 10 ms, stiff within half a millimetre
_STIFFNESS_W = 0.5  # of the coupling against rotation [N m/rad]
_LINK_MASS = 0.005  # of a virtual link [kg]
_LINK_ROUND = (0.4, 0.4, 0.04)  # its inertia about its origin, x, y and along it, over mass and arm squared [-]
_LINK_ARM = 0.1  # longest arm of a virtual link [m]
_LINK_FRICTION = 0.2  # of a shaft or wrist [-]
_ON_THREAD = {"solref": "0.004 1", "solimp": "0.99 0.9999 0.0001"}  # a jaw on a thread, whose links weigh milligrams
_MORE = 2.0  # damping over what a slow motion asks: enough up to 1.17 rad of delay, tan(1.17) / 1.17 = 2
_TICKS = 1.5 + _core.BODY_VELOCITY_DELAY  # delay of the loop and of the tool's velocity [ticks]


@dataclass(frozen=True)
class JawShape:
    """A jaw: a bar from `a` to `b` that turns about a hinge; all (3,) in T, with closed jaws [m]."""

    hinge: Array
    axis: Array
    """Axis of unit length."""
    ratio: float
    """Turn per angle of the jaws [-]."""
    a: Array
    b: Array
    radius: float


@dataclass(frozen=True)
class LinkShape:
    """Shaft or wrist of an instrument: a capsule from `a` to `b`, both (3,) in the frame of its link [m]."""

    name: str
    link: int
    """Its number among the links of the arm."""
    joints: tuple[bool, ...]
    """Whether each joint of the arm moves this link."""
    X_WS: Array
    """(4, 4) pose of this link at the start [m]."""
    a: Array
    b: Array
    radius: float

    @property
    def arm(self) -> float:
        """Distance from its origin at which it is as stiff by rotation as by translation [m]."""
        return min(max(float(np.linalg.norm(end)) for end in (self.a, self.b)), _LINK_ARM)


@dataclass(frozen=True)
class ToolShape:
    """A tool as bodies meet it."""

    name: str
    X_WT: Array
    """(4, 4) pose at the start [m]."""
    jaws: tuple[JawShape, ...]
    radius: float
    """Radius of the ball at T [m]."""
    links: tuple[LinkShape, ...] = ()
    """Shaft and wrist; bodies pass through those that are left out."""


@dataclass(frozen=True)
class _Surface:
    """A shape that others can touch."""

    name: str
    body: str
    friction: float
    torsion: float
    moves: bool
    tool: bool = False
    joined: str = ""
    """Body to which a joint connects it."""
    thread: bool = False


class World:
    """Bodies and virtual tools in an engine.

    Args:
        bodies, section: the sections of the scene.
        tools: the tools, in the order of their loops.
        path: resolves the path of a mesh.
        lag: time by which the tool follows the hand, and the force the tool, beyond the loop's own delay [s].
        rate: of the loops [Hz].
        where: where the scene names the bodies, for messages.

    Raises:
        MissingExtraError: MuJoCo is not installed. SceneError: the engine refuses the bodies. MeshError: a mesh cannot
        be read.
    """

    def __init__(
        self,
        bodies: Sequence[BodySection],
        section: EngineSection,
        tools: Sequence[ToolShape],
        path: Callable[[str], Path] = Path,
        where: str = "",
        lag: float = 0.0,
        rate: float = 1000.0,
    ) -> None:
        try:
            import mujoco
        except ImportError:
            raise MissingExtraError("bodies in a scene", "bodies") from None
        self.threaded = True  #: False: the owner of the loops advances the engine, or starts and stops its thread
        self.sections, self.section, self.tools = tuple(bodies), section, tuple(tools)
        self.solids = solids(bodies, path)  #: bodies and links of threads, in the engine's order
        self.shapes = {solid.name: solid.shapes for solid in self.solids}
        self.xml = _model(self.sections, section, self.tools, self.shapes)
        try:
            self.model: Any = mujoco.MjModel.from_xml_string(self.xml)
        except ValueError as error:
            raise SceneError(
                "the engine refuses the bodies",
                where=where,
                why=" ".join(str(error).split()),
                mend="change the shape, mass, name or joint of the body that it names",
            ) from None
        self._moving = {one.name: int(self.model.body(one.name).id) for one in self.solids if one.moves}
        late = _MORE * (lag + _TICKS / rate + section.period)  # a spring that is felt late needs K late of damping
        self.damping = section.stiffness * late if section.damping is None else section.damping
        self.damping_w = _STIFFNESS_W * self.damping / section.stiffness
        self._damp()
        self.data: Any = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        library = next(Path(mujoco.__file__).parent.glob("libmujoco*.so*"), None) or next(
            Path(mujoco.__file__).parent.glob("*mujoco*.d*")
        )
        self._step = ctypes.cast(ctypes.CDLL(str(library)).mj_step, ctypes.c_void_p).value

    @property
    def moving(self) -> list[str]:
        """Names of the free bodies, in the order of `Bodies.states`."""
        return [body.name for body in self.sections if body.free]

    def core(self, snapshot: _core.Snapshot) -> _core.Bodies:
        """The bodies as the loops take them; `snapshot`: the objects of the scene, which they touch."""
        o = _core.BodiesOptions()
        state = [self.data.qpos, self.data.qvel, self.data.qacc_warmstart]
        o.set_engine(
            int(self._step or 0), self.model._address, self.data._address, state, owner=(self.model, self.data)
        )
        s = self.section
        o.period, o.release = s.period, s.release
        o.stiffness, o.damping, o.force_max = s.stiffness, self.damping, s.force_max
        o.stiffness_w, o.damping_w = _STIFFNESS_W, self.damping_w
        o.low, o.high = np.array(s.field[0]), np.array(s.field[1])
        o.tools = [self._tool(k, tool) for k, tool in enumerate(self.tools)]
        o.bodies = [_core.MovingBody(self._free(name), self._spheres(name)) for name in self.moving]
        made = _core.Bodies(o, snapshot)
        self.core_bodies = made
        return made

    def start(self) -> None:
        """Step the engine in a thread of its own, for loops in real time."""
        if self.threaded:
            self.core_bodies.start()

    def stop(self) -> None:
        """End this thread."""
        if self.threaded:
            self.core_bodies.stop()

    def states(self) -> dict[str, Any]:
        """Newest states of the free bodies (`_core.Bodies.states`), in the order of `moving`."""
        return dict(self.core_bodies.states())

    def faults(self) -> list[str]:
        """What went wrong with the engine, in words: cause; mend."""
        found, words = self.states(), []
        if found["silences"]:
            words.append(
                f"the engine of the bodies stood still for more than 50 ms, {_times(found['silences'])}, and the tools "
                "felt nothing of it; mend: relieve this machine, or raise engine.period"
            )
        if found["restarts"]:
            words.append(
                f"the state of the engine was not finite, {_times(found['restarts'])}, and all bodies began anew; "
                "mend: lower engine.period, or make light bodies heavier"
            )
        return words

    def drawn(self) -> dict[str, Array]:
        """Position [m] and quaternion w x y z (7,) of every body and link of a thread that moves, in W.

        For pictures and records: they are read while the engine may be stepping, and may lie a step apart.
        """
        xpos, xquat = np.array(self.data.xpos), np.array(self.data.xquat)
        return {name: np.r_[xpos[k], xquat[k]] for name, k in self._moving.items()}

    def _free(self, name: str) -> _core.EngineBody:
        joint, body = self.model.joint(f"{name}/free"), self.model.body(name)
        q, v, b = int(joint.qposadr[0]), int(joint.dofadr[0]), int(body.id)
        data = self.data
        return _core.EngineBody(data.qpos[q : q + 7], data.qvel[v : v + 6], data.xfrc_applied[b], np.array(body.ipos))

    def _damp(self) -> None:
        """The implicit part of the couplings (bodies.hpp, `EngineTool`)."""
        T, s = self.section.period, self.section
        for tool in self.tools:
            v = int(self.model.joint(f"{tool.name}/tool/free").dofadr[0])
            self.model.dof_damping[v : v + 3] = self.damping + T * s.stiffness
            self.model.dof_damping[v + 3 : v + 6] = self.damping_w + T * _STIFFNESS_W
            for link in tool.links:
                w = int(self.model.joint(f"{tool.name}/{link.name}/free").dofadr[0])
                self.model.dof_damping[w : w + 3] = self.model.dof_damping[v : v + 3]
                self.model.dof_damping[w + 3 : w + 6] = self._share_w(link) * self.model.dof_damping[v + 3 : v + 6]

    def _share_w(self, link: LinkShape) -> float:
        """Stiffness of a link's coupling against rotation over that of a tool [-]."""
        return self.section.stiffness * link.arm**2 / _STIFFNESS_W

    def _tool(self, number: int, tool: ToolShape) -> _core.EngineTool:
        data, n = self.data, len(self.moving)
        jaws, grips = [], []
        for k in range(len(tool.jaws)):
            a = int(self.model.actuator(f"{tool.name}/drive{k}").id)
            jaws.append(data.ctrl[a : a + 1])
            first = int(self.model.sensor(f"{tool.name}/grip{k}/0").adr[0]) if n else 0
            grips.append(data.sensordata[first : first + 4 * n])
        made = _core.EngineTool(self._free(f"{tool.name}/tool"), jaws, [jaw.ratio for jaw in tool.jaws], grips, n)
        for link in tool.links:
            made.add_link(self._free(f"{tool.name}/{link.name}"), link.link, list(link.joints), self._share_w(link))
        return made

    def _spheres(self, name: str) -> list[_core.ToolSphere]:
        section = next(body for body in self.sections if body.name == name)
        if not section.touches:
            return []
        return [_core.ToolSphere(p, r) for p, r in spheres(self.shapes[name], _core.MAX_SPHERES)]


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n} times"


def _model(
    bodies: Sequence[BodySection], section: EngineSection, tools: Sequence[ToolShape],
    shapes: dict[str, list[Primitive]],
) -> str:  # fmt: skip
    """The engine's model as XML."""
    root = Xml.Element("mujoco")
    _add(root, "compiler", angle="radian", autolimits="true", balanceinertia="true")
    _add(root, "size", memory="32M")
    option = _add(
        root, "option", timestep=f"{section.period:.9g}", gravity=numbers(section.gravity), integrator="implicitfast",
        cone="elliptic", impratio="20", noslip_iterations="8",
    )  # fmt: skip
    _add(option, "flag", autoreset="disable")
    assets, world = _add(root, "asset"), _add(root, "worldbody")
    drives, sensors, contacts = (_add(root, name) for name in ("actuator", "sensor", "contact"))
    surfaces: list[_Surface] = []
    nodes: dict[str, Xml.Element] = {}
    for body in bodies:
        parent = world if body.joint is None else nodes[body.joint.to]
        nodes[body.name] = node = _body(parent, body)
        volume = sum(shape.volume for shape in shapes[body.name])
        for k, shape in enumerate(shapes[body.name]):
            name = f"{body.name}/{k}"
            _geom(
                assets, node, name, shape, body, shape.volume / volume if volume > 0.0 else 1.0 / len(shapes[body.name])
            )
            surfaces.append(_Surface(name, body.name, body.friction, body.torsion, not body.fixed,
                                     joined=body.joint.to if body.joint else ""))  # fmt: skip
        if body.thread is not None:
            names = _thread(node, body)
            surfaces += [_Surface(name, name, body.friction, 0.0, True, thread=True) for name in names]
    free = [body.name for body in bodies if body.free]
    for tool in tools:
        _tool(world, drives, sensors, tool, section, free)
        names = [f"{tool.name}/ball", *(f"{tool.name}/jaw{k}" for k in range(len(tool.jaws)))]
        surfaces += [_Surface(name, f"{tool.name}/tool", section.friction, 0.0, True, True) for name in names]
        for link in tool.links:
            name = f"{tool.name}/{link.name}"
            _link(world, name, link)
            surfaces.append(_Surface(name, name, _LINK_FRICTION, 0.0, True, True))
    _pairs(contacts, surfaces)
    return str(Xml.tostring(root, encoding="unicode"))


def _add(parent: Xml.Element, tag: str, **attributes: str) -> Xml.Element:
    return Xml.SubElement(parent, tag, attributes)


def _place(X: Array) -> dict[str, str]:
    return {"pos": numbers(X[:3, 3]), "quat": numbers(quaternions(X[:3, :3]))}


def _body(parent: Xml.Element, body: BodySection) -> Xml.Element:
    node = _add(parent, "body", name=body.name, **_place(body.pose.matrix()))
    if body.free:
        _add(node, "freejoint", name=f"{body.name}/free")
    elif body.joint is not None and body.joint.kind != "weld":
        joint = body.joint
        _add(
            node, "joint", name=f"{body.name}/joint", type=joint.kind, pos=numbers(joint.at), axis=numbers(joint.axis),
            damping=f"{joint.damping:.9g}", stiffness=f"{joint.stiffness:.9g}",
        )  # fmt: skip
    return node


def _geom(assets: Xml.Element, node: Xml.Element, name: str, shape: Primitive, body: BodySection, share: float) -> None:
    given = {"contype": "2", "conaffinity": "0"}  # threads alone meet by these masks; all else meets by _pairs
    if body.mass is not None:
        given["mass"] = f"{body.mass * share:.9g}"
    else:
        given["density"] = f"{body.density or 1000.0:.9g}"
    if shape.kind == "mesh":
        assert shape.vertices is not None
        assert shape.faces is not None
        _add(assets, "mesh", name=name, vertex=numbers(shape.vertices.ravel()),
                       face=" ".join(map(str, shape.faces.ravel())))  # fmt: skip
        given["mesh"] = name
    else:
        given["size"] = numbers(shape.size)
    _add(node, "geom", name=name, type=shape.kind, **_place(shape.X_OS), **given)


def _pairs(contacts: Xml.Element, surfaces: Sequence[_Surface]) -> None:
    """Contacts between all shapes that can meet.

    The engine softens the sliding direction of a contact as much as the normal one unless a pair says otherwise, and
    then a sliding body hovers: its friction came out up to 30 % wrong.
    """
    for a, b in combinations(surfaces, 2):
        if a.body == b.body or not (a.moves or b.moves) or (a.tool and b.tool):
            continue
        if a.joined == b.body or b.joined == a.body:  # they overlap at their joint
            continue
        if (a.thread or b.thread) and not (a.tool or b.tool):  # the masks let threads meet bodies, and not each other
            continue
        mu, torsion = max(a.friction, b.friction), max(a.torsion, b.torsion)
        law = _ON_THREAD if a.thread or b.thread else _SOLID
        _add(
            contacts, "pair", geom1=a.name, geom2=b.name, condim="4" if torsion > 0.0 else "3", solreffriction="0.1 1",
            friction=numbers((mu, mu, max(torsion, 1e-6), 1e-4, 1e-4)), **law,
        )  # fmt: skip


def _thread(node: Xml.Element, body: BodySection) -> list[str]:
    """Add the thread of a body; returns the names of its links."""
    chain = body.thread
    assert chain is not None
    each = chain.length / chain.links
    for k in range(chain.links):
        name = f"{body.name}/thread{k}"
        node = _add(node, "body", name=name, pos=f"0 0 {0.0 if k == 0 else each:.9g}")
        _add(node, "joint", type="ball", damping=f"{chain.damping:.9g}", armature="1e-9")
        _add(
            node, "geom", name=name, type="capsule", fromto=f"0 0 0 0 0 {each:.9g}", size=f"{chain.radius:.9g}",
            condim="3", density=f"{chain.density:.9g}", friction=f"{body.friction:.9g}", contype="0", conaffinity="2",
            **_SOLID,
        )  # fmt: skip
    return [f"{body.name}/thread{k}" for k in range(chain.links)]


def _tool(
    world: Xml.Element, drives: Xml.Element, sensors: Xml.Element, tool: ToolShape, section: EngineSection,
    free: Sequence[str],
) -> None:  # fmt: skip
    """A free body at T whose jaws are driven; tools do not meet each other here (docs/pairs.md)."""
    base = _add(world, "body", name=f"{tool.name}/tool", gravcomp="1", **_place(tool.X_WT))
    _add(base, "freejoint", name=f"{tool.name}/tool/free")
    _add(base, "inertial", pos="0 0 0", mass=f"{TOOL_MASS:g}", diaginertia=numbers((_TOOL_INERTIA,) * 3))
    common = {"contype": "0", "conaffinity": "0", "mass": "0"}
    _add(base, "geom", name=f"{tool.name}/ball", type="sphere", size=f"{tool.radius:.9g}", **common)
    for k, jaw in enumerate(tool.jaws):
        name = f"{tool.name}/jaw{k}"
        node = _add(base, "body", name=name, pos=numbers(jaw.hinge), gravcomp="1")
        _add(node, "joint", name=name, type="hinge", axis=numbers(jaw.axis), armature=f"{_JAW_INERTIA:g}",
                       damping=f"{_JAW_DAMPING:g}")  # fmt: skip
        middle = 0.5 * (jaw.a + jaw.b) - jaw.hinge
        _add(node, "inertial", pos=numbers(middle), mass=f"{_JAW_MASS:g}", diaginertia="1e-8 1e-8 1e-8")
        _add(node, "geom", name=name, type="box", **_bar(jaw), **common)
        _add(drives, "position", name=f"{tool.name}/drive{k}", joint=name, kp=f"{_JAW_STIFFNESS:g}",
                       forcerange=f"{-section.grip:.9g} {section.grip:.9g}")  # fmt: skip
        for i, body in enumerate(free):
            _add(sensors, "contact", name=f"{tool.name}/grip{k}/{i}", geom1=name, subtree2=body,
                           data="found force", reduce="netforce", num="1")  # fmt: skip


def _link(world: Xml.Element, name: str, link: LinkShape) -> None:
    """A free body at its link: as the tool it meets the bodies alone, neither tools nor other links."""
    base = _add(world, "body", name=name, gravcomp="1", **_place(link.X_WS))
    _add(base, "freejoint", name=f"{name}/free")
    _add(base, "inertial", pos="0 0 0", mass=f"{_LINK_MASS:g}",
                       diaginertia=numbers(_LINK_MASS * link.arm**2 * np.array(_LINK_ROUND)))  # fmt: skip
    _add(
        base, "geom", name=name, type="capsule", fromto=numbers((*link.a, *link.b)), mass="0",
        size=f"{link.radius:.9g}", contype="0", conaffinity="0",
    )  # fmt: skip


def _bar(jaw: JawShape) -> dict[str, str]:
    """The face of a jaw: a bar whose inner side lies in the middle of the closed jaws at its tip."""
    along = jaw.b - jaw.a
    length = float(np.linalg.norm(along))
    z = along / length
    y = np.asarray(jaw.axis) - z * float(np.dot(jaw.axis, z))
    y /= np.linalg.norm(y)
    x = np.cross(y, z)
    thick = max(abs(float(np.dot(jaw.b - jaw.hinge, x))), 0.0008)
    X = np.eye(4)
    X[:3, :3] = np.stack([x, y, z], axis=1)
    X[:3, 3] = jaw.a - jaw.hinge + 0.6 * along  # the first fifth, at the hinge, touches nothing
    return {"size": numbers((thick, _JAW_WIDTH, 0.4 * length + 0.0005)), **_place(X)}
