"""A contact method `early`, a fixture geometry `rod` and a command `palpate weigh` outside of Palpate's repository."""

from typing import ClassVar

from palpate import _guidance  # noqa: F401 - has the base class of Rod
from palpate.base.values import Place, Positive
from palpate.scene.guidance import Shape

from . import _own_parts


class Rod(Shape):
    """All points within a radius of the line between two places."""

    key: ClassVar[str] = "rod"
    start: Place
    end: Place
    radius: Positive

    def make(self, context, X_WF):
        return _own_parts.Rod(context.place(self.start, X_WF), context.place(self.end, X_WF), self.radius)
