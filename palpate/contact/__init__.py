"""Stage ``contact``: render a prescribed tool path through the very contact and force code of the loop."""

from palpate.contact.rendering import Rendered, render

__all__ = ["Rendered", "render"]
