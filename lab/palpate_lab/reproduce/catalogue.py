"""All items in the order of the paper."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from functools import cache
from importlib import import_module

from palpate.base.errors import PalpateError
from palpate_lab.reproduce.item import Item

NAMES = (
    "fig1", "fig2", "eq1", "eq2", "eq3", "eq4", "eq5", "eq6", "eq7", "eq8", "eq9", "eq10", "eq11", "eq12", "eq13",
    "fig3", "fig4", "fig5", "approach", "eq14", "eq15", "eq16", "eq17", "fig6", "fig7", "fig8", "fig9", "fig10",
    "fig11",
    "eq18", "eq19", "eq20", "fig12", "noise", "mesh", "fig13", "alg1", "table1",
)  # fmt: skip
"""Names in the order in which the paper refers to the items."""

_MODULES = ("running", "dynamics", "force", "gravity", "loop", "geometry", "meshes", "remedies", "wall")


@cache
def items() -> dict[str, Item]:
    """All items by name, in the order of the paper."""
    found = {
        item.name: item for name in _MODULES for item in import_module(f"palpate_lab.reproduce.items.{name}").ITEMS
    }
    return {name: found[name] for name in NAMES}


def chosen(names: Sequence[str]) -> list[str]:
    """The names of the items that were asked for, in the paper's order; ``all`` are all, ``eq1..5`` five of them.

    Raises:
        PalpateError: a name is unknown; the message has the nearest ones.
    """
    asked: set[str] = set()
    for name in names:
        key = name.lower().strip()
        if several := _span(key):
            asked.update(several)
        elif key == "all":
            asked.update(NAMES)
        elif key in NAMES:
            asked.add(key)
        else:
            near = difflib.get_close_matches(key, (*NAMES, "all"), n=3, cutoff=0.5)
            mend = f"did you mean {' or '.join(near)}? " if near else ""
            raise PalpateError(
                f"the paper has no item {name!r}",
                mend=f"{mend}the items are all, fig1 to fig13, table1, eq1 to eq20, alg1, approach, noise and mesh",
            )
    return [name for name in NAMES if name in asked]


def _span(key: str) -> list[str]:
    """The names of a span such as ``eq1..5`` or ``fig6..fig11``; empty if it is not one, or not of this paper."""
    found = re.fullmatch(r"(fig|eq)(\d{1,2})\.\.(?:\1)?(\d{1,2})", key)
    names = [] if found is None else [f"{found[1]}{k}" for k in range(int(found[2]), int(found[3]) + 1)]
    return names if set(names) <= set(NAMES) else []
