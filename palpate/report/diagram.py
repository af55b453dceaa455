"""The haptic loop of a run after the paper's Fig 3: each stage with its law and its recorded signals."""

from __future__ import annotations

from html import escape

from palpate.record.layout import topic
from palpate.record.ticks import Signal
from palpate.report.run import Run

_LAWS = {
    "hand": ("Hand", "mass, damping, stiffness; follows an intended path", True),
    "leader": ("Leader arm (MTM)", "M(q) q̈ + C q̇ + G = τ + Jᵀ F<sub>hand</sub>", True),
    "mapping": ("Mapping", "tool goal = scaled motion of the handle", False),
    "follower": ("Follower arm (PSM)", "moves the tool tip x to the goal", True),
    "contact": ("Contact", "proxy x<sub>d</sub> stays on the surface; δx = x<sub>d</sub> − x", False),
    "force": ("Force law", "F = K δx − B ẋ", False),
    "stability": (
        "Stability",
        "virtual coupling, low-pass, passivity controller, caps, watchdog, energy ledger",
        False,
    ),
    "torque": ("Torque", "τ = Jᵀ F + Ĝ(q)  (Eq 13)", False),
}
"""Title, law and whether simulated, by stage. Motion flows through the first four stages, force through the others."""

_SYMBOLS = {
    "q": "q", "v": "q̇", "gripper": "pinch", "p_LH": "p<sub>LH</sub>", "quat_LH": "R<sub>LH</sub>",
    "v_LH": "v<sub>LH</sub>", "F_cell_L": "F<sub>cell</sub>", "p_hand_L": "p<sub>hand</sub>",
    "p_WT_goal": "x<sub>goal</sub>", "q_follower": "q<sub>f</sub>", "jaw": "jaw", "p_WT": "x",
    "quat_WT": "R<sub>WT</sub>", "p_WP": "x<sub>d</sub>", "normal": "n", "delta_x": "δx", "depth": "depth",
    "contacts": "contacts", "F_T_W": "F", "F_spring_W": "K δx", "F_damping_W": "−B ẋ", "status": "status",
    "F_H_L": "F<sub>L</sub>", "F_H_H": "F<sub>H</sub>", "energy_port": "E<sub>port</sub>",
    "energy_spring": "E<sub>spring</sub>", "energy_damping": "E<sub>damping</sub>", "energy_cut": "E<sub>cut</sub>",
    "energy_passivity": "E<sub>passivity</sub>", "energy_low_pass": "E<sub>low-pass</sub>",
    "energy_coupling": "E<sub>coupling</sub>", "energy_source": "E<sub>objects</sub>",
    "energy_stored": "E<sub>stored</sub>", "energy_reserved": "E<sub>reserved</sub>", "lag_ms": "lag",
    "tau": "τ", "tau_force": "Jᵀ F", "tau_gravity": "Ĝ(q)", "tau_platform": "τ<sub>4</sub>",
}  # fmt: skip


def diagram(run: Run) -> str:
    """The loop as HTML: two rows on a wide page, one column on a phone."""
    cards = [_card(stage, i, run) for i, stage in enumerate(_LAWS)]
    return f'<div class="loop">{"".join(cards)}</div>'


def _card(stage: str, index: int, run: Run) -> str:
    title, law, simulated = _LAWS[stage]
    recorded = [s for s in run.record.signals.values() if s.stage == stage]
    chips = "".join(_chip(signal) for signal in recorded)
    tag = '<span class="tag">simulated</span>' if simulated else ""
    return (
        f'<div class="stage s{index}"><h3>{title}{tag}</h3><p class="law">{law}</p><ul class="chips">{chips}</ul></div>'
    )


def _chip(signal: Signal) -> str:
    unit = {"1": "", "bits": "", "rad|m": "rad, m"}.get(signal.unit, signal.unit)
    frame = f" in {signal.frame}" if signal.frame else ""
    label = f"{signal.name}: {signal.doc}{f' [{unit}]' if unit else ''}{frame}"
    shown = f" <small>{escape(unit)}</small>" if unit else ""
    return f'<li title="{escape(label)}">{_SYMBOLS.get(signal.name, escape(signal.name))}{shown}</li>'


def signal_table(run: Run) -> str:
    """HTML table of every recorded signal: symbol, channel, unit, frame, meaning."""
    lines = []
    order = {stage: i for i, stage in enumerate(_LAWS, start=1)}
    for s in sorted(run.record.signals.values(), key=lambda s: order.get(s.stage, 0)):
        size = f" × {s.size}" if s.size > 1 else ""
        lines.append(
            f"<tr><td>{_SYMBOLS.get(s.name, s.name)}</td><td><code>{topic(s)}</code></td>"
            f"<td>{escape(s.unit)}{size}</td><td>{s.frame or '–'}</td><td>{escape(s.doc)}</td></tr>"
        )
    head = "<tr><th>symbol</th><th>channel</th><th>unit</th><th>frame</th><th>meaning</th></tr>"
    return f'<div class="scroll"><table class="signals">{head}{"".join(lines)}</table></div>'
