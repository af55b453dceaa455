"""The left-hand panel of a viewer of several pairs: a gauge a hand, a plot of all forces, and the rates of the run."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from html import escape
from typing import Any

import numpy as np
import viser
from viser import uplot

from palpate.record.lag import in_words as lag_in_words
from palpate.record.ticks import Ticks
from palpate.viewer.device import DeviceDrawing
from palpate.viewer.gauges import LAG_HINT, POINTS, WINDOW
from palpate.viewer.rates_panel import RatesPanel
from palpate.viewer.stage import Stage
from palpate.viewer.words import in_words

_HAND = (
    '<div style="border-left:4px solid {color};padding:2px 8px;margin:6px 0" id="palpate-pair-{name}">'
    '<div style="display:flex;justify-content:space-between"><b>{name}</b>'
    '<span style="font-size:22px;font-weight:650">{force:.2f} N</span></div>'
    '<div style="height:9px;background:#8883;border-right:3px solid #e12626" title="full at the force cap, {cap:g} N">'
    '<div style="height:9px;width:{full:.1f}%;background:{color}"></div></div>'
    '<div style="font-size:12px;opacity:.8">{words}</div>'
    '<div style="font-size:12px;opacity:.8">penetration {depth:.1f} mm, other instruments {other}</div>'
    '<div style="font-size:12px;opacity:.8" title="{lag_hint}">filter lag '
    '<span id="palpate-lag-{name}">{lag}</span></div>{device}</div>'
)
_DEVICE = (
    '<div style="font-size:12px;opacity:.8" id="palpate-range-{name}">range left '
    '<span style="{style}">{left}</span></div>'
    '<div style="font-size:12px;opacity:.8" id="palpate-mapping-{name}">mapping {mapping}</div>'
)


class PairGauges:
    """Shows force, penetration, filter lag and status of every pair, and the range of a device.

    Args:
        server: the server of the page.
        stages: of each pair, by name.
        devices: pictures of the devices that lead pairs, by name of the pair.
        colors: red, green, blue of each pair.
        handle_distance: distance of two handles below which a warning appears [m].
        rates: rows of the panel of rates; None leaves it out.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        stages: dict[str, Stage],
        devices: Mapping[str, DeviceDrawing],
        colors: Mapping[str, tuple[int, int, int]],
        handle_distance: float,
        rates: Callable[[], list[Any]] | None,
    ) -> None:
        self._stages, self._devices, self._near = stages, devices, handle_distance
        self._colors = {name: "#{:02x}{:02x}{:02x}".format(*colors[name]) for name in stages}
        self._t: deque[float] = deque(maxlen=POINTS)
        self._forces: dict[str, deque[float]] = {name: deque(maxlen=POINTS) for name in stages}
        self._began = time.perf_counter()
        gui = server.gui
        panel = gui.add_panel()
        with panel.add_tab("Feel", viser.Icon.ACTIVITY):
            self._figures = gui.add_html("")
            lines = [
                uplot.Series(label=name, stroke=self._colors[name], width=1.6, points={"show": False})
                for name in stages
            ]
            top = 1.1 * max(stage.force_cap for stage in stages.values())
            self._plot = gui.add_uplot(
                (np.array([0.0, 1.0]), *[np.zeros(2)] * len(stages)),
                (uplot.Series(label="t [s]"), *lines),
                title="force on each hand [N]",
                scales={"x": uplot.Scale(time=False), "y": uplot.Scale(auto=False, range=(0.0, top))},
                legend={"show": False},
                cursor={"show": False},
                height=160,
                padding=(8, 10, 0, 0),
            )
        self._rates = None
        if rates is not None:
            with panel.add_tab("Rates", viser.Icon.CLOCK):
                self._rates = RatesPanel(gui, rates)
        panel.dock_left()
        panel.set_width(320)

    def add(self, ticks: Mapping[str, Ticks]) -> None:
        """Adds the newest ticks to the plot, on the time axis of the page."""
        self._t.append(time.perf_counter() - self._began)
        for name, tick in ticks.items():
            self._forces[name].append(float(np.linalg.norm(tick["F_H_L"])))

    def show(self, ticks: Mapping[str, Ticks], paused: bool, over: Collection[str] = ()) -> None:
        """Updates the read-outs; over: names of the pairs whose run has ended."""
        hands = "".join(self._hand(name, tick, paused, name in over) for name, tick in ticks.items())
        closest = min(float(tick["handle_gap"]) for tick in ticks.values())
        warning = ""
        if 0.0 < closest < self._near:
            warning = (
                '<div style="background:#e12626;color:white;font-weight:650;padding:4px 8px" id="palpate-handles">'
                f"handles {1e3 * closest:.0f} mm apart: clutch, and move one hand away</div>"
            )
        self._figures.content = f'<div style="padding:6px 10px">{warning}{hands}</div>'
        if self._rates is not None:
            self._rates.show()

    def _hand(self, name: str, tick: Ticks, paused: bool, over: bool) -> str:
        stage = self._stages[name]
        force, push = float(np.linalg.norm(tick["F_H_L"])), float(np.linalg.norm(tick["F_instrument_W"]))
        gap = float(tick["instrument_gap"])
        away = f"{1e3 * gap:.0f} mm away" if 0.0 < gap < np.inf else "not there"
        other = f"push with {push:.2f} N" if push > 0.0 else away
        return _HAND.format(
            name=escape(name),
            color=self._colors[name],
            force=force,
            cap=stage.force_cap,
            full=100.0 * min(force / stage.force_cap, 1.0),
            words="<br>".join(in_words(tick, stage.force_cap, paused, stage.near, over)),
            depth=1e3 * float(tick["depth"]),
            other=other,
            lag_hint=LAG_HINT,
            lag=lag_in_words(tick["lag_ms"]),
            device=self._device(name, tick),
        )

    def _device(self, name: str, tick: Ticks) -> str:
        """What is left of the range of a device, and its mapping; empty for a simulated arm."""
        device = self._devices.get(name)
        if device is None:
            return ""
        style = "color:#e12626;font-weight:700" if device.at_edge(tick) else ""
        left = device.left_in_words(tick)
        return _DEVICE.format(name=escape(name), style=style, left=left, mapping=escape(device.mark.mapping))

    def plot(self) -> None:
        """Updates the plot."""
        if len(self._t) < 2:
            return
        t = np.array(self._t)
        seen = t > t[-1] - WINDOW
        self._plot.data = (t[seen], *(np.array(one)[seen] for one in self._forces.values()))
