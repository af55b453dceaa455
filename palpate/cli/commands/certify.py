"""`palpate certify`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from palpate.devices.certificate import Certificate
    from palpate.devices.certificate.entry import Entry
    from palpate.devices.certificate.touched import Touched
    from palpate.scene import Scene
    from palpate.scene.rig import Rig

_COLOURS = {"stable": "green", "marginal": "yellow", "unstable": "red"}


@dataclass
class Command:
    """Predict which stiffness is stable with a scene's arms, loop and hand, and explain why, without a run.

    examples:
      palpate certify scenes/palpation.yaml
      palpate certify my.yaml --json certificate.json --figure certificate.png
      palpate certify device.yaml --stiffness 400 --damping 1

    The stability boundary is exact for small motions: the model includes sampling, delay, the follower's servo and
    every filter (docs/certificate.md).
    """

    scene: Positional[Path]
    """Scene file (YAML), or a device file of `palpate device bench`."""
    stiffness: Annotated[float | None, arg(metavar="N_PER_M")] = None
    """Of a device: stiffness of a wall to judge [N/m]; only the limit when left out."""
    damping: Annotated[float, arg(metavar="N_S_PER_M")] = 0.0
    """Of a device: damping of the wall [N s/m]."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the stability boundary over damping and stiffness."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the certificate as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print which objects of the scene are stable, and by what margin; returns the exit code."""
        from palpate.base.arrays.plain import plain
        from palpate.devices.certificate import certify_all
        from palpate.devices.certificate.device import is_device
        from palpate.devices.certificate.entry import stiffness
        from palpate.devices.certificate.remote import remote_limits
        from palpate.devices.certificate.scene import worst_of
        from palpate.devices.certificate.touched import touched
        from palpate.devices.certificate.words import number
        from palpate.scene import Scene
        from palpate.scene.rig import build

        console = console_for(self.json)
        for file in (self.json, self.figure):
            require_writable(file)
        if is_device(self.scene):
            return self._certify_device(console)
        scene = Scene.load(self.scene)
        if scene.pairs:
            return self._certify_pairs(scene, console)
        rig = build(scene)
        surfaces = touched(rig)
        found = certify_all(scene, rig=rig)
        console.print(_table(surfaces, found))
        worst = worst_of(found)
        hands = ", ".join(f"{name} {number(k)}" for name, k in worst.hands.items())
        say(console, worst.reason, f"{worst.name}:", f"bold {_COLOURS[worst.verdict or 'stable']}")
        say(console, f"stable below {hands} N/m", "with other hands:", "bold")
        pressed, force_scale = _entries(rig), rig.options().mapping.force_scale
        for name, K, presses in pressed:
            depths = ", ".join(
                f"{e.measured_mm:.3g} mm at {e.force_N:g} N ({e.certified_mm:.3g} mm by K)" for e in presses
            )
            measured = f"{stiffness(presses, force_scale):.4g} N/m"
            say(console, f"{depths}; stiffness {measured} (simulated)", f"entry into {name}, {K:g} N/m:", "bold")
        if self.figure is not None:
            _draw(scene, surfaces, found, self.figure)
            say(console, str(self.figure), "figure:")
        limits = remote_limits(rig)
        if limits is not None:
            say(console, limits.words(), "remote:", "bold")
        fixtures = [_Pressed(name, K, stiffness(presses, force_scale), presses) for name, K, presses in pressed]
        objects = [{"name": one.name, **plain(one.figures())} for one in found]
        write_json(self.json, {**plain(worst.figures()), "objects": objects, "fixtures": fixtures,
                               "remote": None if limits is None else plain(limits)})  # fmt: skip
        return 0

    def _certify_pairs(self, scene: Scene, console: Console) -> int:
        """Certify each pair, alone and with another instrument that touches the tool at the same time."""
        from palpate.base.arrays.plain import plain
        from palpate.devices.certificate.scene import certificates, worst_of
        from palpate.devices.certificate.touched import touched
        from palpate.devices.certificate.words import number
        from palpate.scene.together import build_pairs

        if self.figure is not None:
            mend = "certify one pair as a scene of its own, or leave --figure out"
            raise PalpateError("--figure draws one pair, and the scene has several", mend=mend)
        out = {}
        for name, rig in build_pairs(scene).items():
            say(console, name, "pair", "bold")
            alone, surfaces = certificates(rig.scene, None, None, rig), touched(rig)
            # The tool may press a surface and another instrument along the same direction: their stiffnesses add.
            K = max(surface.K for surface in surfaces) + scene.instruments.stiffness
            shared = certificates(rig.scene, K, None, rig)
            console.print(_table(surfaces, alone))
            worst, both = worst_of(alone), worst_of(shared)
            say(console, worst.reason, f"{worst.name}:", f"bold {_COLOURS[worst.verdict or 'stable']}")
            words = f"{K:g} N/m in all, stable below {number(both.k_max)} N/m: {both.verdict}"
            say(console, words, "with another instrument on the tool:", f"bold {_COLOURS[both.verdict or 'stable']}")
            objects = [{"name": one.name, **plain(one.figures())} for one in alone]
            touching = {"K_instrument_N_per_m": scene.instruments.stiffness, **plain(both.figures())}
            out[name] = {**plain(worst.figures()), "objects": objects, "with_instrument": touching}
        write_json(self.json, {"pairs": out})
        return 0

    def _certify_device(self, console: Console) -> int:
        from palpate.devices.certificate import DeviceModel, certify

        found = certify(DeviceModel.load(self.scene), self.stiffness, self.damping)
        say(console, found.reason, f"{self.scene.stem}:", f"bold {_COLOURS[found.verdict or 'stable']}")
        write_json(self.json, found.figures())
        return 0


@dataclass(frozen=True)
class _Pressed:
    """A soft fixture that was pressed, as docs/json.md describes it."""

    name: str
    K_N_per_m: float
    measured_N_per_m: float
    entries: list[Entry]


def _entries(rig: Rig) -> list[tuple[str, float, list[Entry]]]:
    """Name, stiffness times authority [N/m] and simulated presses of each soft fixture that has a stiffness."""
    from palpate.devices.certificate.entry import entries
    from palpate.devices.certificate.guidance import acts_on_position
    from palpate.scene import fixtures

    soft = [f for f in fixtures.each(rig.fixtures) if acts_on_position(f) and not f.policy.hard and f.stiffness > 0.0]
    each = [(f.name, f.policy.authority * f.stiffness, f.policy.authority * f.damping) for f in soft]
    return [(name, K, entries(rig, K, B)) for name, K, B in each]


def _table(surfaces: list[Touched], found: list[Certificate]) -> Table:
    from rich.markup import escape
    from rich.table import Table

    from palpate.devices.certificate.words import number

    out = Table(box=None, pad_edge=False, title="stiffness on the tool's side", title_justify="left")
    for column in (
        "object",
        "K [N/m]",
        "B [N s/m]",
        "stable below [N/m]",
        "passive below [N/m]",
        "oscillates at [Hz]",
        "verdict",
    ):
        out.add_column(escape(column), justify="left" if column in ("object", "verdict") else "right")
    for surface, one in zip(surfaces, found, strict=True):
        passive = one.bounds["colgate_brown_with_hand"]
        out.add_row(surface.name, f"{surface.K:g}", f"{one.B:g}", number(one.k_max), number(passive),
                    f"{one.frequency:.3g}", one.verdict, style=_COLOURS[one.verdict or "stable"])  # fmt: skip
    return out


def _draw(scene: Scene, surfaces: list[Touched], found: list[Certificate], path: Path) -> None:
    from palpate.devices.certificate.figure import Point, draw
    from palpate.devices.certificate.scene import worst_of

    points = [
        Point(surface.name, one.B, surface.K, one.verdict or "stable")
        for surface, one in zip(surfaces, found, strict=True)
    ]
    draw(worst_of(found), points, f"{scene.title}: stable below the line", path)
