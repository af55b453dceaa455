"""The kinds of random loops: what each adds to a scene, and how its ways run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate_lab.verify.fuzz.loops import bodies, draw
from palpate_lab.verify.fuzz.loops.draw import Site, number, vector
from palpate_lab.verify.fuzz.loops.ways import Way

_REACH = 0.2334  # farthest start of the tool from the remote centre of the shipped follower [m]

Run = Literal["still", "moving", "soft", "felt", "session"]


@dataclass(frozen=True)
class Loop:
    """A scene and a closed way of the tool in it."""

    kind: str
    scene: Content
    way: Way
    run: Run = "still"
    """Without the passivity layer, slowly, both ways: still: at rest at each place; moving: on a moving object; soft:
    on tissue. With the layer: felt: at the speed of a hand; session: by a simulated hand on a simulated arm."""
    cycles: int = 1  #: times that the way is run
    speed: float = 0.05  #: felt, soft: mean speed of the hand on an edge [m/s]
    axes: int = 6  #: axes of the wrench that the device renders; 3: no moments
    toggle: str = ""  #: felt: what changes between two cycles: clutch, pedal or list
    clock: str = ""  #: felt: how the loop differs from what it says: slow, late, lost, wrong or delayed
    credit: float = 0.0  #: felt: energy that the layer may lend in all [J]


def surface(rng: np.random.Generator) -> list[Loop]:
    """A surface without friction."""
    s = draw.site(rng, bodies.SMOOTH + bodies.MADE)
    return _still("surface", s, [draw.wander(s), draw.across(s)])


def valley(rng: np.random.Generator) -> list[Loop]:
    """A valley or hills, some narrower than the tool."""
    s = draw.site(rng, (bodies.valley, bodies.relief))
    return _still("valley", s, [draw.wander(s), draw.across(s)])


def stick(rng: np.random.Generator) -> list[Loop]:
    """Friction: loops within its cone, and others."""
    s = draw.site(rng, bodies.SMOOTH + bodies.CURVED + bodies.MADE)
    held = _friction(s)
    return _still("stick", s, [draw.stick(s, held), draw.stick(s, held), draw.wander(s)])


def regions(rng: np.random.Generator) -> list[Loop]:
    """Hard and soft regions below the surface."""
    s = draw.site(rng, bodies.SMOOTH + bodies.CURVED)
    _regions(s)
    return _still("regions", s, [draw.across(s), draw.wander(s), draw.wander(s)])


def axes(rng: np.random.Generator) -> list[Loop]:
    """A stiffness of three axes."""
    s = draw.site(rng, bodies.SMOOTH)
    s.object["stiffness"] = [number(s.stiffness * f) for f in np.exp(rng.uniform(-1.2, 0.0, 3))]
    return _still("axes", s, [draw.across(s), draw.wander(s)])


def hard(rng: np.random.Generator) -> list[Loop]:
    """Hard fixtures beside a surface."""
    s = draw.site(rng, bodies.SMOOTH + bodies.MADE)
    fixtures = [_fixture(s) | {"hard": True, "law": _spring(rng)} for _ in range(int(rng.integers(1, 3)))]
    s.scene["guidance"] = fixtures
    return _still("hard", s, [draw.across(s), draw.wander(s)])


def reach(rng: np.random.Generator) -> list[Loop]:
    """A surface at the end of the follower's reach."""
    s = draw.site(rng, bodies.SMOOTH)
    start = np.array(s.scene["operator"]["path"][0]["xyz"])
    up = np.array([0.0, 0.0, 1.0]) + 0.1 * rng.normal(size=3)
    base = start + _REACH * rng.uniform(0.95, 1.0) * up / np.linalg.norm(up)
    s.scene["arms"]["follower"]["base"] = {"xyz": vector(base), "rpy_deg": [0.0, 0.0, float(rng.integers(-180, 180))]}
    s.depth *= 2
    return _still("reach", s, [draw.across(s), draw.wander(s)])


def soft_fixtures(rng: np.random.Generator) -> list[Loop]:
    """Soft fixtures of several laws and priorities, with a surface."""
    s = draw.site(rng, bodies.SMOOTH)
    fixtures = []
    for _ in range(int(rng.integers(1, 4))):
        one = _fixture(s) | {"law": _law(rng), "priority": int(rng.integers(0, 3))}
        if rng.uniform() < 0.3:
            one["authority"] = number(rng.uniform(0.2, 1.0))
        if rng.uniform() < 0.2:
            one["ramps"] = [{"by": "distance", "start": number(rng.uniform(0.002, 0.01)), "end": 0.0}]
        fixtures.append(one)
    s.scene["guidance"] = fixtures
    s.depth += 0.003
    return _still("soft fixtures", s, [draw.across(s), draw.wander(s), draw.wander(s)])


def cap(rng: np.random.Generator) -> list[Loop]:
    """A force cap that acts, over regions, fixtures or friction."""
    s = draw.site(rng, bodies.SMOOTH)
    what = rng.integers(3)
    if what == 0:
        _regions(s)
    elif what == 1:
        s.scene["guidance"] = [_fixture(s) | {"law": _law(rng)}]
    held = _friction(s) if what == 2 else 0.0
    most = s.stiffness * s.depth * s.scene["mapping"]["force_scale"]
    s.scene["stability"]["force_cap"] = number(max(most * rng.uniform(0.3, 0.9), 0.02))
    return _still("cap", s, [draw.across(s), draw.stick(s, held) if what == 2 else draw.wander(s)])


def whole_tool(rng: np.random.Generator) -> list[Loop]:
    """Several spheres of the tool, or all of it, which also turns."""
    s = draw.site(rng, bodies.SMOOTH)
    _spheres(s)
    if rng.uniform() < 0.3:
        s.scene["guidance"] = [_orient(s)]
    return _still("whole tool", s, [draw.wander(s, 0.3), draw.wander(s, 0.3)])


def torqueless(rng: np.random.Generator) -> list[Loop]:
    """A device without torque whose handle turns, with the layer on."""
    s = draw.site(rng, bodies.SMOOTH)
    _spheres(s)
    made = _felt("torqueless", s, [draw.wander(s, 0.4)])
    for one in made:
        del one.scene["stability"]["moment_cap"]  # without it, a device renders forces only
    return [replace(one, axes=3, cycles=8) for one in made]


def engage(rng: np.random.Generator) -> list[Loop]:
    """Fixtures that engage near and release far away, with the layer on."""
    s = draw.site(rng, bodies.SMOOTH)
    near = number(rng.uniform(0.002, 0.006))
    wide = number(near * rng.uniform(2, 4))
    law = {"name": "potential", "stiffness": number(rng.uniform(100, 500)), "force": number(rng.uniform(0.5, 4.0)),
           "range": wide, "damping": 0.0}  # fmt: skip
    at, n = s.spot()
    ball = {"sphere": {"radius": 0.02, "at": vector(at - 0.02 * n)}}
    one = {"geometry": ball, "role": "forbid", "law": law, "engage": near, "release": number(wide * 0.95)}
    s.scene["guidance"] = [one]
    s.scene["objects"][0]["stiffness"] = 50.0
    s.radius = s.scene["contact"]["radius"] = 0.001
    s.scene["operator"]["path"][0]["xyz"] = vector(at + n * wide * 1.2)
    start = np.array(s.scene["operator"]["path"][0]["xyz"])
    low = at + n * near * 0.5
    way = Way(np.array([start, low, start]), np.zeros((3, 3)))
    return [replace(made, cycles=12) for made in _felt("engage", s, [way])]


def toggles(rng: np.random.Generator) -> list[Loop]:
    """A clutch, a guidance pedal or a list of fixtures that changes in each cycle, with the layer on."""
    s = draw.site(rng, bodies.SMOOTH)
    what = str(rng.choice(["clutch", "pedal", "list"]))
    if what != "clutch":
        one = _fixture(s) | {"law": _spring(rng)}
        if what == "pedal":
            one["ramps"] = [{"by": "pedal", "start": 0.0, "end": 1.0}]
        s.scene["guidance"] = [one]
    made = _felt(what, s, [draw.wander(s)])
    return [replace(one, toggle=what, cycles=12, credit=0.0 if what == "clutch" else 0.03) for one in made]


def clocks(rng: np.random.Generator) -> list[Loop]:
    """A loop that calls more slowly or less evenly than it says, or acts later, with the layer on."""
    s = draw.site(rng, bodies.SMOOTH)
    made = _felt("clock", s, [draw.across(s), draw.wander(s)])
    return [replace(one, clock=str(rng.choice(["slow", "late", "lost", "wrong", "delayed"])), cycles=6) for one in made]


def moving(rng: np.random.Generator) -> list[Loop]:
    """A moving object, with and without friction: energy relative to the object."""
    s = draw.site(rng, (*bodies.SMOOTH[1:], bodies.ball_mesh))
    held = _friction(s) if rng.uniform() < 0.7 else 0.0
    if rng.uniform() < 0.3:
        _regions(s)
    s.object["motion"] = {
        "amplitude": vector(rng.uniform(-0.004, 0.004, 3)),
        "turn_deg": vector(rng.uniform(-10, 10, 3)),
        "period": number(rng.uniform(0.5, 2.0)),
        "phase_deg": 0.0,
        "velocity": vector(rng.uniform(-0.005, 0.005, 3)),
        "spin_deg": vector(rng.uniform(-20, 20, 3) * rng.integers(2)),
    }
    ways = [draw.stick(s, held, 3) if held else draw.across(s), draw.wander(s)]
    return [Loop("moving", s.scene, way, "moving") for way in ways]


def tissue(rng: np.random.Generator) -> list[Loop]:
    """A soft body, with and without friction."""
    s = draw.site(rng, (bodies.slab,))
    s.object.pop("stiffness"), s.object.pop("damping")
    s.radius = s.scene["contact"]["radius"] = number(rng.uniform(0.002, 0.005))
    half = 0.5 * s.object["box"]["size"][2]
    fixed = {"at": [0.0, 0.0, -half], "box": [1.0, 1.0, 0.002]}
    s.object["tissue"] = {"preset": str(rng.choice(["liver", "kidney", "fat", "gallbladder"])), "resolution": 0.008,
                          "fixed": [fixed]}  # fmt: skip
    s.depth, s.reach = 0.8 * s.radius, 0.004
    held = _friction(s) if rng.uniform() < 0.7 else 0.0
    s.scene["operator"]["path"][0]["xyz"] = vector(s.tool(0.0, 0.0, -0.002))
    s.scene["rates"] = {"haptic": 1000.0}
    way = draw.stick(s, held, 2) if held else draw.across(s)
    return [Loop("tissue", s.scene, way, "soft", speed=0.02)]


def laws(rng: np.random.Generator) -> list[Loop]:
    """A control law of a simulated arm, with a simulated hand: energy at the load cell."""
    law = str(rng.choice(["stiffness", "impedance", "admittance", "admittance"]))
    torque: Content = {"law": law}
    mass, damping = number(rng.uniform(0.1, 1.0)), float(rng.choice([0.0, number(rng.uniform(0, 3))]))
    if law == "admittance":
        torque |= {"virtual_mass": mass, "virtual_damping": damping}
    elif law == "impedance" and rng.uniform() < 0.5:
        torque |= {"virtual_mass": mass, "shape_inertia": True}
    scale = number(rng.uniform(0.3, 1.0))
    ball: Content = {"name": "ball", "sphere": {"radius": number(rng.uniform(0.01, 0.03))},
                     "pose": {"xyz": [-0.035, -0.012, 0.02]}, "stiffness": number(rng.uniform(200, 800)),
                     "friction": float(rng.choice([0.0, number(rng.uniform(0, 0.5))]))}  # fmt: skip
    scene = {
        "objects": [ball],
        "mapping": {"scale": scale},
        "torque": torque,
        "operator": {
            "hand": str(rng.choice(["relaxed", "relaxed", "light", "normal", "firm"])),
            "palpate": {"force": number(rng.uniform(0.5, 2.0)), "length": 0.02, "approach": 0.6, "press": 0.5,
                        "slide": 2.0, "leave": 0.5, "hover": 0.008},
        },
    }  # fmt: skip
    return [Loop("laws", scene, Way(np.zeros((2, 3)), np.zeros((2, 3))), "session")]


def mixed(rng: np.random.Generator) -> list[Loop]:
    """Several bodies, regions, friction and fixtures at once."""
    s = draw.site(rng, bodies.SMOOTH + bodies.CURVED)
    held = _friction(s) if rng.uniform() < 0.5 else 0.0
    if rng.uniform() < 0.5:
        _regions(s)
    if rng.uniform() < 0.5:
        _second_body(s)
    if rng.uniform() < 0.7:
        fixtures = [_fixture(s) | {"law": _law(rng)} for _ in range(int(rng.integers(1, 3)))]
        for one in fixtures:
            if rng.uniform() < 0.4:
                one |= {"hard": True, "law": _spring(rng)}
        s.scene["guidance"] = fixtures
    return _still("mixed", s, [draw.across(s), draw.wander(s), draw.stick(s, held, 3) if held else draw.wander(s)])


KINDS: dict[Callable[[np.random.Generator], list[Loop]], float] = {
    surface: 1.0, valley: 0.7, stick: 2.0, regions: 2.0, axes: 0.7, hard: 2.0, reach: 0.7, soft_fixtures: 1.5,
    cap: 1.0, whole_tool: 1.0, torqueless: 0.3, engage: 0.3, toggles: 0.5, clocks: 0.5, moving: 0.4,
    tissue: 0.05, laws: 0.1, mixed: 2.0,
}  # fmt: skip
"""How often each kind is drawn, relative to the others."""


def loops(seed: int, kind: str = "") -> list[Loop]:
    """The loops of a seed; kind: name of a function of `KINDS`, drawn when left out."""
    rng = np.random.default_rng(seed)
    for one in KINDS:
        if one.__name__ == kind:
            return one(rng)
    share = np.array(list(KINDS.values()))
    return list(KINDS)[rng.choice(len(share), p=share / share.sum())](rng)


def _still(kind: str, s: Site, ways: list[Way]) -> list[Loop]:
    """The ways without the layer, and one of them with it."""
    return [Loop(kind, s.scene, way) for way in ways] + _felt(kind, s, ways[:1])


def _felt(kind: str, s: Site, ways: list[Way]) -> list[Loop]:
    hardest = max(s.stiffness, *(one["stiffness"] for one in s.object.get("regions", ())), 0.0)
    felt = hardest * s.scene["mapping"]["scale"] * s.scene["mapping"]["force_scale"]
    stability = {
        "passivity": str(s.rng.choice(["observer", "observer", "tank"])),
        "force_cap": min(s.scene["stability"]["force_cap"], draw.FORCE),
        "rate_cap": number(max(50.0, 0.03 * felt)),
        "moment_cap": 1.0,
    }
    scene = s.scene | {"stability": stability, "rates": {"haptic": 1000.0}}
    speed = number(np.exp(s.rng.uniform(np.log(0.02), np.log(0.2))))
    return [Loop(kind, scene, way, "felt", cycles=4, speed=speed) for way in ways]


def _friction(s: Site) -> float:
    """Add friction; the coefficient up to which the tool sticks."""
    mu = number(s.rng.uniform(0.05, 1.0))
    s.object["friction"] = mu
    if s.rng.uniform() < 0.4:
        s.object["static_friction"] = number(mu * s.rng.uniform(1.0, 3.0))
    return float(s.object.get("static_friction", mu))


def _regions(s: Site) -> None:
    found = []
    for _ in range(int(s.rng.integers(1, 3))):
        u, v = s.beside()
        p, n = s.body.spot(u, v)
        one: Content = {"at": vector(p - n * s.depth * s.rng.uniform(0.0, 1.0)),
                        "blend": number(s.rng.uniform(0.001, 0.006)),
                        "stiffness": number(s.stiffness * np.exp(s.rng.uniform(-1.5, 1.1)))}  # fmt: skip
        if s.rng.uniform() < 0.7:
            one["radius"] = number(s.rng.uniform(0.001, 0.006))
        else:
            one |= {"box": [number(x) for x in s.rng.uniform(0.002, 0.01, 3)]}
        found.append(one)
    s.object["regions"] = found


def _second_body(s: Site) -> None:
    other = bodies.SMOOTH[s.rng.integers(1, len(bodies.SMOOTH))](s.rng)
    p, n = s.spot(*s.beside())
    at = p + 0.01 * s.rng.normal(size=3) - 0.5 * other.size * n
    pose = {"xyz": vector(at), "rpy_deg": vector(s.rng.uniform(-180, 180, 3))}
    s.scene["objects"].append(
        {"name": "other", **other.section, "pose": pose, "stiffness": s.stiffness, "damping": 0.0}
    )


def _spheres(s: Site) -> None:
    if s.rng.uniform() < 0.5:
        s.scene["contact"]["whole_tool"] = True
        return
    r = s.radius
    s.scene["contact"]["spheres"] = [
        {"link": "tip", "at": vector(1.5 * r * s.rng.normal(size=3)), "radius": number(r * s.rng.uniform(0.5, 1.5))}
        for _ in range(int(s.rng.integers(1, 4)))
    ]


def _spring(rng: np.random.Generator) -> Content:
    return {"name": "spring", "stiffness": number(rng.uniform(50, 800)), "damping": 0.0}


def _law(rng: np.random.Generator) -> Content:
    name = str(rng.choice(["spring", "potential", "optimise"]))
    law = _spring(rng) | {"name": name}
    if name != "spring":
        law["force"] = number(rng.uniform(0.3, 5.0))
    if name == "potential":
        law["range"] = number(rng.uniform(0.003, 0.015))
    return law


def _fixture(s: Site) -> Content:
    """A geometry and a role near the way."""
    rng = s.rng
    p, n = s.spot(*s.beside())
    tilted = n + 0.6 * rng.normal(size=3)
    tilted /= np.linalg.norm(tilted)
    at = p + n * rng.uniform(-0.004, 0.004)
    role: Content = {"name": str(rng.choice(["forbid", "forbid", "keep-in", "guide"]))}
    if rng.uniform() < 0.4:
        role["margin"] = number(rng.uniform(0.0, 0.002))
    return {"geometry": _geometry(rng, str(role["name"]), at, tilted), "role": role}


def _geometry(rng: np.random.Generator, role: str, at: Array, n: Array) -> Content:
    away = 1.0 if role == "keep-in" else -1.0  # which side of `at` is inside
    R = number(rng.uniform(0.005, 0.03))
    rpy = vector(rng.uniform(-180, 180, 3))
    line = {"start": vector(at - 0.03 * _across(rng, n)), "end": vector(at + 0.03 * _across(rng, n))}
    shapes: list[Content] = [
        {"plane": {"at": vector(at), "normal": vector(-away * n)}},
        {"sphere": {"radius": R, "at": vector(at + away * R * n)}},
        {"box": {"size": [2 * R, number(3 * R), 2 * R], "pose": {"xyz": vector(at + away * R * n), "rpy_deg": rpy}}},
        {"cylinder": {"radius": R, "length": 0.05, "pose": {"xyz": vector(at + away * R * n), "rpy_deg": rpy}}},
        {
            "cone": {
                "entry": vector(at - away * 0.05 * n),
                "target": vector(at + away * 0.01 * n),
                "half_angle_deg": 30.0,
            }
        },
    ]
    if role == "guide":
        shapes += [{"line": line}, {"point": {"at": vector(at)}}, {"line": line | {"endless": True}}]
    return shapes[rng.integers(len(shapes))]


def _across(rng: np.random.Generator, n: Array) -> Array:
    a = np.cross(n, rng.normal(size=3))
    return np.asarray(a / np.linalg.norm(a))


def _orient(s: Site) -> Content:
    law = {"name": "spring", "turning_stiffness": number(s.rng.uniform(0.01, 0.5)), "turning_damping": 0.0}
    at, n = s.spot()
    line = {"line": {"start": vector(at), "end": vector(at + 0.05 * n)}}
    return {"geometry": line, "role": {"name": "orient", "target": "axis"}, "law": law}
