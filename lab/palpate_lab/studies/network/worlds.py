"""Worlds, motions and hands of the study."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from palpate import _core, _network
from palpate.arm.hands import PRESETS
from palpate.base.arrays import Array
from palpate.world.shapes.analytic import Torus, WavySheet

TICK = 1e-3  # period of both ends [s]
HEIGHT = 0.012  # of the hand above the surface at the start [m]
REST = 1.2  # time at rest at the start, besides twice the round trip [s]
STOPPED = 1.0  # time after the hand has stopped, after which the drift counts [s]
STILL = 1e-3  # share of its last motion by which a hand that has stopped still swings
RADIUS = 0.002  # of the tool [m]
FASTEST = 0.06  # aim of a hand [m/s]
DEEPEST = 0.012  # farthest that a hand aims below the surface [m]

SURFACES = ("plane", "sphere", "mesh", "registered")


@cache
def _surface(world: str) -> tuple[_core.Surface, float]:
    """Surface in O, and the height of its top above O's origin [m]."""
    if world == "plane":
        return _core.Plane(), 0.0
    if world == "sphere":
        return _core.Sphere(0.03), 0.03
    shape = Torus() if world == "mesh" else WavySheet()
    vertices, triangles = shape.mesh(4000)
    surface = _core.Mesh(np.ascontiguousarray(vertices), np.ascontiguousarray(triangles, np.int32))
    point = np.array([[shape.major if isinstance(shape, Torus) else 0.0, 0.0, 0.1]])
    _, nearest, _ = surface.nearest(point)
    return surface, float(nearest[0, 2])


@dataclass(frozen=True)
class World:
    """A surface as it is, and how far both ends are mistaken about it."""

    kind: str = "plane"
    K: float = 500.0
    """Stiffness [N/m]."""
    mu: float = 0.0
    assumed_K: float = 300.0
    """Stiffness in the scene of both ends [N/m]."""
    error: tuple[float, float, float] = (0.0, 0.0, -0.002)
    """True place minus that in the scene [m]."""
    turn: float = 0.0
    """True orientation relative to the scene, about the x axis [rad]."""
    breathing: tuple[float, float] = (0.0, 4.0)
    """Amplitude along z [m], and period [s]: a motion that both ends know."""
    hidden: bool = False
    """True: the scene of both ends has no object; what the tool touches is felt as a plane."""

    @property
    def top(self) -> Array:
        """The point above which the hand moves (3,) [m]."""
        height = _surface(self.kind)[1]
        return np.array([Torus().major if self.kind == "mesh" else 0.0, 0.0, height])

    def snapshot(self, true: bool) -> _core.Snapshot:
        """The world as it is, or as the scene has it."""
        if self.hidden and not true:
            return _core.Snapshot([])
        surface, _ = _surface(self.kind)
        X, c, s = np.eye(4), np.cos(self.turn), np.sin(self.turn)
        if true:
            X[1:3, 1:3] = [[c, -s], [s, c]]
            X[:3, 3] = np.array(self.error) + self.top - X[:3, :3] @ self.top
        K, mu = (self.K, self.mu) if true else (self.assumed_K, 0.0)
        amplitude, period = self.breathing
        wave = _core.Wave(shift=np.array([0.0, 0.0, amplitude]), period=period)
        motion = _core.Motion(waves=[wave] if amplitude else [])
        material = _core.Material(K=np.full(3, K), mu=mu, mu_static=mu)
        return _core.Snapshot([_core.Object("organ", surface, X_WO=X, material=material, motion=motion)])


def swings(hand: str) -> float:
    """Time until a hand that no longer aims anywhere else has stopped [s]: a relaxed one swings on its own spring."""
    handle, preset = _network.TrialOptions(), PRESETS[hand]
    mass, damping = handle.handle_mass + preset.mass, handle.handle_damping + preset.damping
    slowest = max(np.roots([mass, damping, preset.stiffness]).real)
    return float(np.log(STILL) / slowest)


@dataclass(frozen=True)
class Motion:
    """A hand that presses several times, slides a little, and rests above the surface at the end."""

    hand: str = "normal"
    force: float = 1.5
    """Force that the hand aims for [N]."""
    presses: int = 6
    press: float = 1.0
    """Duration of a press, or longer if the hand would be faster than `FASTEST` [s]."""
    slide: float = 0.003
    """Sideways motion [m]."""

    def path(self, world: World, round_trip: float) -> Array:
        """Intended position of the hand at every tick (n, 3) [m]."""
        rest = REST + 2.0 * round_trip
        aim = min(self.force / PRESETS[self.hand].stiffness, DEEPEST) + self.force / world.K
        depth = HEIGHT + aim + max(-world.error[2], 0.0)
        press = max(self.press, 1.3 * np.pi * depth / FASTEST)
        t = np.arange(0.0, rest + self.presses * press + swings(self.hand) + STOPPED, TICK)
        active = np.clip((t - rest) / press, 0.0, self.presses)
        down = np.clip(1.3 * 0.5 * (1.0 - np.cos(2.0 * np.pi * active)), 0.0, 1.0)
        phase = active / self.presses
        side = self.slide * np.sin(2.0 * np.pi * phase)
        z = RADIUS + HEIGHT - depth * down
        return world.top + np.column_stack([side, 0.5 * side * np.cos(2.0 * np.pi * phase), z])


def places(world: World, rows: int = 2, columns: int = 3, apart: float = 0.005) -> Array:
    """Points (rows columns, 3) clear of the top of a world, below which a person palpates [m]."""
    x, y = (apart * (np.arange(n) - 0.5 * (n - 1)) for n in (columns, rows))
    beside = np.array([(a, b, RADIUS + HEIGHT) for b in y for a in x])
    return np.asarray(world.top + beside)


def options(mode: str, hand: str, round_trip: float, seed: int, hidden: bool = False) -> _network.TrialOptions:
    """Options of a trial of this mode with this hand in a hidden or known world; links are added by the caller."""
    o = _network.TrialOptions()
    ends, site, stability = o.operator_end, o.site, o.operator_end.stability
    ends.mode = site.mode = _network.Mode[mode]
    ends.planes = site.planes = hidden
    ends.radius = site.radius = RADIUS
    stability.allowance, stability.moving_share = 3e-4, 1.0
    if mode == "direct":
        stability.passivity = "off"
    ends.stability, o.operator_end, o.site = stability, ends, site
    preset = PRESETS[hand]
    o.hand_mass, o.hand_damping, o.hand_stiffness = preset.mass, preset.damping, preset.stiffness
    o.round_trip, o.seed, o.after_release = round_trip, seed, hidden
    return o
