"""The left-hand panel: numeric read-outs, live plots, and the legend of the arrows."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
import viser
from viser import uplot

from palpate.record.lag import in_words as lag_in_words
from palpate.record.ticks import Ticks
from palpate.viewer.drawing import DEFLECTION_SCALE, FORCE_SCALE, Arrow, Drawing
from palpate.viewer.fixtures import in_words as guided_in_words
from palpate.viewer.stage import Stage
from palpate.viewer.words import in_words

HISTORY = ("t", "F_H_L", "depth", "cycle_us")
"""Signals of the plots and percentiles."""
WINDOW = 10.0
"""Time span of the plots [s]."""
POINTS = 400
"""Largest number of points in a plot."""
PAIRS = 4
"""Largest number of contacts listed one by one."""

LAG_HINT = "Delay that each filter of the force adds now; negative where the virtual coupling leads."
"""Explanation of the line of filter lags."""

_FIGURE = (
    '<div style="flex:1"><div style="opacity:.65;font-size:11px">{label}</div>'
    '<div style="font-size:24px;font-weight:650;font-variant-numeric:tabular-nums" id="{id}">{value}</div></div>'
)
_STORED = "Energy that the hand has put in. The passivity controller limits the force so that it returns no more."
_CONTACTS = "Spring force of each contact, before force scale, damping, filters and force cap act on it."
_RANGE = "Way of the handle to the nearest side of the workspace of the device, along the axis of its base."
_NOTE = '<div style="padding:0 10px 4px 10px;font-size:12px;line-height:1.35;opacity:.75">{}</div>'
_SWATCH = '<span style="color:{color};font-weight:700">&#9632;</span>'


class Gauges:
    """Shows force, penetration, cycle times and status of a tick."""

    def __init__(self, server: viser.ViserServer, stage: Stage, drawing: Drawing) -> None:
        """Docks the panel on the left."""
        self._stage, self._drawing = stage, drawing
        self._deepest = 5.0  # upper end of the scale of depths [mm]
        self._limit: tuple[float, float] | None = None  # damping [N s/m] and its largest stable stiffness [N/m]
        self._t: deque[float] = deque(maxlen=POINTS)
        self._force: deque[float] = deque(maxlen=POINTS)
        self._depth: deque[float] = deque(maxlen=POINTS)
        self._cycle: deque[float] = deque(maxlen=2000)
        gui = server.gui
        panel = self.panel = gui.add_panel()
        with panel.add_tab("Feel", viser.Icon.ACTIVITY):
            self._figures = gui.add_html("")
            self._force_plot = _plot(gui, "force on the hand [N]", "#e12626", 1.1 * stage.force_cap)
            self._depth_plot = _plot(gui, "penetration [mm]", "#3b82d6", self._deepest)
            _legend(gui, stage, drawing)
        panel.dock_left()
        panel.set_width(320)

    def add(self, tick: Ticks) -> None:
        """Adds a tick to the plots and percentiles, unless it was added before."""
        t = float(tick["t"])
        if self._t and t < self._t[-1]:
            self.clear()
        if not self._t or t > self._t[-1]:
            self._t.append(t)
            self._force.append(float(np.linalg.norm(tick["F_H_L"])))
            self._depth.append(1e3 * float(tick["depth"]))
            self._cycle.append(float(tick["cycle_us"]))

    def clear(self) -> None:
        """Empties the plots and percentiles, after a jump in time."""
        for series in (self._t, self._force, self._depth, self._cycle):
            series.clear()

    def set_history(self, ticks: Ticks) -> None:
        """Replaces the ticks of the plots by these (n,)."""
        self.clear()
        self._t.extend(ticks["t"].tolist())
        self._force.extend(np.linalg.norm(ticks["F_H_L"], axis=1).tolist())
        self._depth.extend((1e3 * ticks["depth"]).tolist())
        self._cycle.extend(ticks["cycle_us"].tolist())

    def show(
        self,
        tick: Ticks,
        paused: bool = False,
        stiffness_scale: float = 1.0,
        damping_scale: float = 1.0,
        over: bool = False,
    ) -> None:
        """Updates the read-outs; the scales are the console's factors on stiffness and damping of the tissue
        [-]; over: the run has ended."""
        words = in_words(tick, self._stage.force_cap, paused, self._stage.near, over)
        cycle = "-"
        measured = [us for us in self._cycle if us > 0.0]  # cycle times are zero in a lockstep record
        if measured:
            p50, p99 = np.percentile(measured, [50, 99])
            cycle = f"{p50:.1f} / {p99:.1f} &micro;s"
        pairs = self._stage.touches(tick)
        touches = "<br>".join(pairs[:PAIRS] + ([f"and {len(pairs) - PAIRS} more"] if len(pairs) > PAIRS else []))
        guidance = guided_in_words(tick, tuple(mark.name for mark in self._stage.fixtures))
        figures = [
            ("force", "force", f"{np.linalg.norm(tick['F_H_L']):.2f} N"),
            ("penetration", "depth", f"{1e3 * float(tick['depth']):.1f} mm"),
        ]
        row = "".join(_FIGURE.format(label=label, id=f"palpate-{id_}", value=v) for label, id_, v in figures)
        small = "display:flex;flex-wrap:wrap;justify-content:space-between;font-size:12px;opacity:.8"
        self._figures.content = (
            '<div style="padding:6px 10px 2px 10px">'
            f'<div style="font-size:14px;font-weight:600" id="palpate-status">{"<br>".join(words)}</div>'
            f'<div style="display:flex;margin:6px 0">{row}</div>'
            f"{_bar(float(np.linalg.norm(tick['F_H_L'])), self._stage.force_cap)}"
            f'<div style="{small}"><span>time</span><span id="palpate-time">{float(tick["t"]):.2f} s</span></div>'
            f'<div style="{small}"><span>cycle p50 / p99</span><span>{cycle}</span></div>'
            f'<div style="{small}"><span>stability margin</span>{self._margin(stiffness_scale, damping_scale)}</div>'
            f'<div style="{small}" title="{LAG_HINT}"><span>filter lag</span>'
            f'<span id="palpate-lag">{lag_in_words(tick["lag_ms"])}</span></div>'
            f'<div style="{small}" title="{_STORED}"><span>energy stored from the hand</span>'
            f"<span>{1e3 * float(tick['energy_stored']):.1f} mJ</span></div>"
            f"{self._device_line(tick, small)}"
            f"{_remote(tick, small)}"
            f'<div style="{small}" title="{_CONTACTS}"><span>contact springs at the tool</span></div>'
            f'<div style="font-size:12px;opacity:.8" id="palpate-touches" title="{_CONTACTS}">{touches or "none"}</div>'
            f'<div style="font-size:12px;opacity:.8" id="palpate-guidance">{guidance}</div>'
            "</div>"
        )

    def _device_line(self, tick: Ticks, style: str) -> str:
        """What is left of the range of the device, and the mapping; empty for a simulated arm."""
        device = self._drawing.device
        if device is None:
            return ""
        red = ";color:#e12626;font-weight:700" if device.at_edge(tick) else ""
        return (
            f'<div style="{style}" title="{_RANGE}"><span>range left</span>'
            f'<span id="palpate-range" style="{red}">{device.left_in_words(tick)}</span></div>'
            f'<div style="{style}"><span>mapping</span><span id="palpate-mapping">{device.mark.mapping}</span></div>'
        )

    def _margin(self, stiffness_scale: float, damping_scale: float) -> str:
        """Largest stable stiffness over the present one, and its value [N/m]; red when exceeded (`palpate certify`)."""
        stage, K, B = self._stage, self._stage.stiffness * stiffness_scale, self._stage.damping * damping_scale
        if stage.stable_below is None:
            return '<span id="palpate-margin">-</span>'
        if self._limit is None or self._limit[0] != B:
            self._limit = (B, stage.stable_below(B))
        limit = self._limit[1]
        red = ";color:#e12626;font-weight:700" if limit <= K else ""
        times = f"&times; {limit / K:.2g}" if K > 0.0 else "any"
        return f'<span id="palpate-margin" style="opacity:1{red}">{times}, stable below {limit:.0f} N/m</span>'

    def plot(self) -> None:
        """Updates the plots."""
        if len(self._t) < 2:
            return
        t = np.array(self._t)
        seen = t > t[-1] - WINDOW
        self._force_plot.data = (t[seen], np.array(self._force)[seen])
        depth = np.array(self._depth)[seen]
        self._depth_plot.data = (t[seen], depth)
        if float(depth.max()) > self._deepest:
            self._deepest = 1.5 * float(depth.max())
            self._depth_plot.scales = _scales(self._deepest)


def _remote(tick: Ticks, style: str) -> str:
    """Delays, packets and forces of a remote site; empty without one."""
    if not tick["remote_link"] > 0:  # NaN in an older record
        return ""
    link = int(tick["remote_link"])
    measured, model = (float(np.linalg.norm(tick[name])) for name in ("F_remote_W", "F_T_W"))
    age, ahead = 1e3 * float(tick["remote_age"]), 1e3 * float(tick["remote_delay"])
    where = f"where the grey ball is {age:.0f} ms ago, here in {ahead:.0f} ms"
    rows = [
        ("link", "stands" if link == 2 else "down: everything holds"),
        ("remote tool", where),
        ("packets", f"{int(tick['remote_received'])}"),
        ("force there measured / felt here", f"{measured:.2f} / {model:.2f} N"),
    ]
    return "".join(f'<div style="{style}"><span>{name}</span><span>{value}</span></div>' for name, value in rows)


def _scales(top: float) -> dict[str, uplot.Scale]:
    """A fixed scale from zero: a signal at rest is a flat line at the bottom."""
    return {"x": uplot.Scale(time=False), "y": uplot.Scale(auto=False, range=(0.0, top))}


def _bar(force: float, cap: float) -> str:
    """The force as a bar that is full at the force cap."""
    full = 100.0 * min(force / cap, 1.0)
    color = "#e12626" if force > 0.98 * cap else "#2f7fc1"
    return (
        f'<div title="full at the force cap" style="height:10px;background:#8883;border-right:3px solid #e12626">'
        f'<div id="palpate-bar" style="height:10px;width:{full:.1f}%;background:{color}"></div></div>'
        f'<div style="text-align:right;font-size:11px;opacity:.65">cap {cap:g} N</div>'
    )


def _plot(gui: viser.GuiApi, title: str, color: str, top: float) -> viser.GuiUplotHandle:
    zero = np.array([0.0, 1.0])
    return gui.add_uplot(
        (zero, np.zeros(2)),
        (uplot.Series(label="t [s]"), uplot.Series(label=title, stroke=color, width=1.6, points={"show": False})),
        title=title,
        scales=_scales(top),
        legend={"show": False},
        cursor={"show": False},
        height=140,
        padding=(8, 10, 0, 0),
    )


def _legend(gui: viser.GuiApi, stage: Stage, drawing: Drawing) -> None:
    rows = [
        ("#e12626", "deflection", f"from tool to proxy, drawn {DEFLECTION_SCALE:g} times as long", drawing.deflection),
        ("#28aa46", "force (spatial)", "force on the hand, in the master's base frame", drawing.force_spatial),
        ("#e12626", "force (body)", "the same, components in the handle's frame", drawing.force_body),
    ]
    with gui.add_folder("Arrows"):
        for color, label, text, arrow in rows:
            box = gui.add_checkbox(label, True, hint=f"show or hide: {text}")
            box.on_update(_shows(arrow))
            gui.add_html(_NOTE.format(_SWATCH.format(color=color) + " " + text))
    gui.add_html(
        _NOTE.format(
            f"{_SWATCH.format(color='#5aaaff')} tool sphere of {1e3 * stage.radius:g} mm radius &nbsp; "
            f"{_SWATCH.format(color='#e8b92c')} proxy, held on the surface &nbsp; "
            f"{_SWATCH.format(color='#e11414')} point of contact<br>"
            f"Force arrows: {1e3 * FORCE_SCALE:g} mm per newton."
        )
    )


def _shows(arrow: Arrow) -> Callable[[viser.GuiEvent[viser.GuiCheckboxHandle]], None]:
    def shows(event: viser.GuiEvent[viser.GuiCheckboxHandle]) -> None:
        arrow.enabled = event.target.value

    return shows
