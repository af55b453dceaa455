"""Stage ``contact``: render a prescribed tool path with the contact and force code of the haptic loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.scene.contact.rendering import Rendered, render

__all__ = ["Rendered", "render"]

_HOMES = {
    "Rendered": "rendering",
    "render": "rendering",
}

__getattr__ = lazy.names(__name__, _HOMES)
