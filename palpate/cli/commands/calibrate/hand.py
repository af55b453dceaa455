"""`palpate calibrate hand`."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.base.errors import refuse_to_overwrite
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.arm.identify.hand import Grip, HandFit

QUANTITIES = (("mass", "kg"), ("damping", "N s/m"), ("stiffness", "N/m"))


@dataclass
class Command:
    """Identify mass, damping and stiffness of a hand from a recorded grip under a push (needs a load cell).

    examples:
      palpate run scenes/grip.yaml --out grip
      palpate calibrate hand grip/grip-*/record.mcap --out my_hand.yaml
      palpate calibrate hand grip.csv --json hand.json

    A recording is a record of Palpate (scenes/grip.yaml makes a suitable push), or a CSV for one direction: t_s, x_m,
    F_N (force of the arm on the hand), and optionally u (the excitation signal, any unit). The command also draws
    HAND.png. Use in a scene: operator: {hand: HAND.yaml}.
    """

    recording: Positional[Path]
    """Record (MCAP) or CSV of a held grip, 16 s or longer."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    out: Annotated[Path | None, arg(metavar="HAND.yaml")] = None
    """The hand file to write."""
    force: bool = False
    """Overwrite existing files."""

    def __call__(self) -> int:
        """Fit the hand, print it, write the hand file, its figure and the JSON."""
        from palpate.arm import hands
        from palpate.arm.identify import grip_recording
        from palpate.arm.identify.hand import figures, fit
        from palpate.base.arrays.plain import plain

        console = console_for(self.json)
        written = [] if self.out is None else [self.out, self.out.with_suffix(".png")]
        for path in written:
            refuse_to_overwrite(path, self.force)
        require_writable(self.json)
        grip = grip_recording.load(self.recording)
        found = fit(grip)
        console.print(_table(found))
        for line in _lines(grip, found):
            say(console, line)
        for warning in found.warnings:
            say(console, warning, "warning:", "yellow")
        if self.out is not None:
            m, b, k = (float(x) for x in found.value)
            hand = hands.Hand(self.out.stem, m, b, k, source=f"fitted to {self.recording.name}, palpate calibrate hand")
            notes = plain(figures(grip, found))
            del notes["warnings"]  # they are about the recording
            hand.save(self.out, notes)
            say(console, f"hand: {self.out}   in a scene: operator: {{hand: {self.out.name}}}")
            if importlib.util.find_spec("matplotlib") is not None:
                from palpate.arm.identify.hand_figure import save

                save(found, written[1])
                say(console, f"figure: {written[1]}")
        write_json(self.json, figures(grip, found))
        return 0


def _table(found: HandFit) -> Table:
    from rich.table import Table

    table = Table(title="the hand, along the push", title_justify="left", box=None)
    for head in ("", "value", "95 % confidence"):
        table.add_column(head, justify="left" if not head else "right")
    for (name, unit), x, (low, high) in zip(QUANTITIES, found.value, found.interval, strict=True):
        table.add_row(name, f"{x:.4g} {unit}", f"{low:.4g} to {high:.4g}")
    return table


def _lines(grip: Grip, found: HandFit) -> list[str]:
    from palpate.arm import hands

    m, b, k = found.value
    direction = (
        ""
        if grip.direction is None
        else ", along ({:.2f}, {:.2f}, {:.2f}) in the leader's base frame".format(*grip.direction)
    )
    nearest = min(hands.PRESETS.values(), key=lambda h: abs(h.stiffness / k - 1) + abs(h.damping / b - 1))
    return [
        f"{found.seconds:.0f} s of grip{direction}; {len(found.f)} frequencies from {found.f.min():.2g} to "
        f"{found.f.max():.2g} Hz, coherence {found.coherence.mean():.2f}",
        f"the force lags by {1e3 * found.lag:.2f} +- {1e3 * found.student * found.lag_std:.2f} ms, "
        f"as {found.cell}; squared residuals are "
        f"{found.misfit:.2g} times what noise explains (p {found.p_misfit:.2g})",
        f"resonance {found.resonance:.1f} Hz, damping ratio {b / (2 * (m * k) ** 0.5):.2f}; a mass with spring and "
        f"damper explains {100 * found.explained:.1f} %",
        f"nearest preset: {nearest.name} ({nearest.mass:g} kg, {nearest.damping:g} N s/m, {nearest.stiffness:g} N/m)",
    ]
