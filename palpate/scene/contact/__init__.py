"""Stage ``contact``: render a prescribed tool path with the contact and force code of the haptic loop."""

from palpate.scene.contact.rendering import Rendered, render

__all__ = ["Rendered", "render"]
