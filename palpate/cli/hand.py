"""`palpate calibrate hand`."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING, Any

from rich.table import Table

from palpate import hands
from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.errors import refuse_to_overwrite
from palpate.identify import grip_recording
from palpate.identify.hand import Grip, HandFit, fit

if TYPE_CHECKING:
    from palpate.cli.calibrate import Hand

QUANTITIES = (("mass", "kg"), ("damping", "N s/m"), ("stiffness", "N/m"))


def hand(o: Hand) -> int:
    """Fit, tell, write the hand, its figure and the JSON."""
    console = console_for(o.json)
    written = [] if o.out is None else [o.out, o.out.with_suffix(".png")]
    for path in written:
        refuse_to_overwrite(path, o.force)
    require_writable(o.json)
    grip = grip_recording.load(o.recording)
    found = fit(grip)
    console.print(_table(found))
    for line in _lines(grip, found):
        say(console, line)
    for warning in found.warnings:
        say(console, warning, "warning:", "yellow")
    if o.out is not None:
        m, b, k = (float(x) for x in found.value)
        told = hands.Hand(o.out.stem, m, b, k, source=f"fitted to {o.recording.name}, palpate calibrate hand")
        told.save(o.out, {key: value for key, value in to_json(grip, found).items() if key != "warnings"})
        say(console, f"hand: {o.out}   in a scene: operator: {{hand: {o.out.name}}}")
        if importlib.util.find_spec("matplotlib") is not None:
            from palpate.identify.hand_figure import save

            save(found, written[1])
            say(console, f"figure: {written[1]}")
    write_json(o.json, to_json(grip, found))
    return 0


def to_json(grip: Grip, found: HandFit) -> dict[str, Any]:
    """The figures as docs/json.md says."""
    names = ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m")
    values = {name: float(x) for name, x in zip(names, found.value, strict=True)}
    intervals = {f"{name}_95": [float(x) for x in row] for name, row in zip(names, found.interval, strict=True)}
    return {
        **values,
        **intervals,
        "resonance_Hz": found.resonance,
        "lines": len(found.f),
        "band_Hz": [float(found.f.min()), float(found.f.max())],
        "coherence": float(found.coherence.mean()),
        "explained": found.explained,
        "direction": list(grip.direction) if grip.direction else None,
        "seconds": found.seconds,
        "warnings": list(found.warnings),
    }


def _table(found: HandFit) -> Table:
    table = Table(title="the hand, along the push", title_justify="left", box=None)
    for head in ("", "value", "95 % confidence (noise)"):
        table.add_column(head, justify="left" if not head else "right")
    for (name, unit), x, (low, high) in zip(QUANTITIES, found.value, found.interval, strict=True):
        table.add_row(name, f"{x:.4g} {unit}", f"{low:.4g} to {high:.4g}")
    return table


def _lines(grip: Grip, found: HandFit) -> list[str]:
    m, b, k = found.value
    where = (
        ""
        if grip.direction is None
        else ", along ({:.2f}, {:.2f}, {:.2f}) of the leader's base".format(*grip.direction)
    )
    near = min(hands.PRESETS.values(), key=lambda h: abs(h.stiffness / k - 1) + abs(h.damping / b - 1))
    return [
        f"{found.seconds:.0f} s of grip{where}; {len(found.f)} lines from {found.f.min():.2g} to "
        f"{found.f.max():.2g} Hz, coherence {found.coherence.mean():.2f}",
        f"resonance {found.resonance:.1f} Hz, damping ratio {b / (2 * (m * k) ** 0.5):.2f}; a mass with spring and "
        f"damper explains {100 * found.explained:.1f} %",
        f"nearest preset: {near.name} ({near.mass:g} kg, {near.damping:g} N s/m, {near.stiffness:g} N/m)",
    ]
