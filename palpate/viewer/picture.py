"""Picture quality: full with a graphics card, light in a browser that renders by software.

`picture.js` finds out how the browser renders, adapts the resolution to the measured frame rate, and reports both. Here
the materials, the lamp's shadow and the environment map follow: one scene for all browsers, so that the picture is
light while any browser needs it. It starts light, because a slow browser would take seconds for its first full frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Any, cast

import viser

from palpate.base import limits
from palpate.viewer.controls import set_value

MODES = ("automatic", "full", "light")
FULL, LIGHT = "standard", "toon5"
"""Materials of the library: physically based, and with five shades, which costs a tenth in software."""
ENOUGH = 0.75
"""Share of the updates that a browser draws if it is fast enough [-]."""
STILL = 5
"""Updates of one tick after which the scene stands still."""
FEWEST = 15.0
"""Fewest updates [1/s]."""
_LONGEST = 2000
"""Longest report that is read [characters]."""
_PIXEL = "data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw=="


@dataclass(frozen=True)
class Browser:
    """How a browser draws, as it reports."""

    renderer: str = "unknown"
    software: bool = False  # no graphics card
    slow: bool = False  # measured too slow for a full picture
    fps: float = 0.0  # frames drawn per second while something moves
    width: int = 0  # of the drawn picture [pixels]
    height: int = 0
    scale: float = 1.0  # pixels drawn for a pixel of the window
    window: int = 0  # width of the window [pixels]; 0: it has not reported


def read(report: str) -> Browser | None:
    """The browser of a report; None if it is not one, for it comes from the network."""
    try:
        found = limits.load_json(report[:_LONGEST])
        return Browser(
            str(found["renderer"]), bool(found["software"]), bool(found["slow"]),
            float(found["fps"]), int(found["width"]), int(found["height"]),
            min(max(float(found.get("scale", 1.0)), 0.1), 10.0), int(found.get("window", 0)),
        )  # fmt: skip
    except (ValueError, KeyError, TypeError, OverflowError):
        return None


class Picture:
    """Switches the picture between full and light, and says which it is and why.

    Args:
        server: the server of the page, which must be our own (`palpate.viewer.page`).
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._materials: list[Any] = []
        self._lamps: list[Any] = []
        self._environment: tuple[tuple[Any, ...], dict[str, Any]] | None = None
        self._background: Any = None
        self._server = server
        self.browsers: dict[int, Browser] = {}
        self.light = True
        self._t, self._same = -1.0, 0  # time of the drawn tick [s], and number of updates since it changed
        self.scene = cast("viser.SceneApi", Recorder(server.scene, self))
        """Where to draw: the nodes made here follow the quality."""
        with server.gui.add_folder("Picture"):
            hint = "Light: without shadows, reflections and smooth edges, for a browser without a graphics card"
            self.mode = server.gui.add_dropdown("quality", MODES, initial_value=MODES[0], hint=hint)
            self._words = server.gui.add_html("")
            self._bridge = server.gui.add_html("")
            self._field = server.gui.add_text("report", "", visible=False)
        self.mode.on_update(lambda _: self._follow())
        self._field.on_update(self._reported)
        server.on_client_disconnect(self._left)
        self._follow()

    def choose(self, mode: str) -> None:
        """Sets the mode: automatic, full or light."""
        set_value(self.mode, mode)
        self._follow()

    def at(self, t: float) -> None:
        """Takes the time of the drawn tick [s]; while it stands still, the light picture is drawn sharp."""
        before = self.still
        self._t, self._same = t, self._same + 1 if t == self._t else 0
        if self.still != before:
            self._follow()

    def scale(self, client: int) -> float:
        """Pixels that a browser draws for a pixel of its window; 1 before it has reported."""
        return self.browsers.get(client, Browser()).scale

    @property
    def still(self) -> bool:
        """True if nothing moves but the camera."""
        return self._same >= STILL

    def rate(self, most: float) -> float:
        """Updates per second that the browsers can draw, at most `most`: others would only cost them time.

        A browser that draws fewer than `ENOUGH` of them gets half as many more as it drew, so that it can become faster
        even if it leaves some out by chance.
        """
        drawn = [one.fps for one in self.browsers.values() if one.fps > 0.0]
        fastest = max(drawn, default=most)
        return most if fastest >= ENOUGH * most else min(max(1.5 * fastest, FEWEST), most)

    def take(self, node: Any) -> None:
        """Lets a new node follow the quality."""
        if hasattr(node, "material"):
            self._materials.append(node)
            node.material = LIGHT if self.light else FULL
        if getattr(node, "cast_shadow", False) and type(node).__name__.endswith("LightHandle"):
            self._lamps.append(node)
            node.cast_shadow = not self.light

    def set_environment(self, *args: Any, **kwargs: Any) -> None:
        """As `configure_environment_map`, for the full picture; the light one has no environment map."""
        self._environment = args, kwargs
        self._apply()

    def set_background(self, image: Any) -> None:
        """As `set_background_image`, for the full picture; behind the light one is the page's own."""
        self._background = image
        self._apply()

    def _follow(self) -> None:
        """Tells the browsers the chosen mode, and applies it."""
        values = f"'{self._field._impl.uuid}','{self.mode.value}',{'true' if self.still else 'false'}"
        call = f"window.palpatePicture&&palpatePicture.follow({values})"
        self._bridge.content = f'<img src="{_PIXEL}" style="display:none" onload="{call}" alt="">'
        self._decide()

    def _reported(self, event: Any) -> None:
        found = read(self._field.value)
        if found is not None and event.client_id is not None:
            self.browsers[event.client_id] = found
            self._decide()

    def _left(self, client: viser.ClientHandle) -> None:
        self.browsers.pop(client.client_id, None)  # the next report of another browser decides

    def _decide(self) -> None:
        needy = any(one.software or one.slow for one in self.browsers.values())
        light = self.mode.value == "light" or (self.mode.value == "automatic" and (needy or not self.browsers))
        if light != self.light:
            self.light = light
            self._apply()
        newest = next(reversed(self.browsers.values()), None)
        self._words.content = (
            f'<div style="padding:0 10px 6px 10px;font-size:12px" id="palpate-picture">{in_words(newest, light)}</div>'
        )

    def _apply(self) -> None:
        with self._server.atomic():
            for node in self._materials:
                node.material = LIGHT if self.light else FULL
            for lamp in self._lamps:
                lamp.cast_shadow = not self.light
            if self._environment is not None:
                args, kwargs = ((None,), {}) if self.light else self._environment
                self._server.scene.configure_environment_map(*args, **kwargs)
            if self._background is not None:
                self._server.scene.set_background_image(None if self.light else self._background)


class Recorder:
    """The interface of a scene that shows every new node to the picture."""

    def __init__(self, scene: viser.SceneApi, picture: Picture) -> None:
        self._scene, self._picture = scene, picture

    def __getattr__(self, name: str) -> Any:
        if name == "configure_environment_map":
            return self._picture.set_environment
        if name == "set_background_image":
            return self._picture.set_background
        found = getattr(self._scene, name)
        if not name.startswith("add_"):
            return found

        def add(*args: Any, **kwargs: Any) -> Any:
            node = found(*args, **kwargs)
            self._picture.take(node)
            return node

        return add


def in_words(browser: Browser | None, light: bool) -> str:
    """The quality, its reason and the measured frame rate, as HTML."""
    if browser is None:
        return "waiting for the browser"
    why = "no graphics card" if browser.software else "slow graphics" if browser.slow else "graphics card"
    what = "light, without shadows and smooth edges" if light else "full"
    rate = f"{browser.fps:.0f} frames/s, " if browser.fps > 0.0 else ""
    drawn = f"{rate}{browser.width} x {browser.height} pixels"
    return f'<span title="{escape(browser.renderer[:200])}">{what}: {why}<br>{drawn}</span>'
