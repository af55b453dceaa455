"""Checks that runs fit into one data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from palpate.base.errors import RecordError
from palpate.export.demonstration import Demonstration

_FREE = {"seed", "duration", "record", "operator"}
"""Sections of a scene in which runs of one data set may differ."""
_PLACED = {"start"}
"""Keys of an arm that follow from the operator's path."""


def require_alike(runs: Sequence[Demonstration], mixed: bool) -> None:
    """Refuse runs of different rates or arms, and of different scenes unless `mixed`.

    Raises:
        RecordError: it names the first difference.
    """
    first = runs[0]
    for run in runs[1:]:
        if run.rate != first.rate:
            what = f"{run.rate:g} ticks/s, and {first.rate:g} in {first.path}"
            raise RecordError(what, where=str(run.path), mend="export runs of one rate into one data set")
        ours, theirs = [_models(one) for one in (run, first)]
        if ours != theirs:
            what = f"the arms are {_list(ours)}, and {_list(theirs)} in {first.path}"
            raise RecordError(what, where=str(run.path), mend="export them into data sets of their own")
        found = None if mixed else _difference(run, first)
        if found is not None:
            place, here, there = found
            what = f"another scene: {place} is {here}, and {there} in {first.path}"
            mend = "give --mixed for a data set over several scenes, or export them apart"
            raise RecordError(what, where=str(run.path), mend=mend)


def _models(run: Demonstration) -> list[str]:
    return [f"{arm.model('leader') or arm.leader} and {arm.model('follower') or arm.name}" for arm in run.arms]


def _list(texts: list[str]) -> str:
    return "; ".join(texts)


def _difference(run: Demonstration, first: Demonstration) -> tuple[str, str, str] | None:
    """The first difference of two scenes: its place, the value here and the value there; None if they are alike."""
    for ours, theirs in zip(run.arms, first.arms, strict=True):
        here, there = _flat(_fixed(ours.scene)), _flat(_fixed(theirs.scene))
        for place in here | there:
            if here.get(place) != there.get(place):
                return place, _short(here.get(place)), _short(there.get(place))
    return None


def _fixed(scene: Mapping[str, Any]) -> dict[str, Any]:
    found = {key: value for key, value in scene.items() if key not in _FREE}
    arms = found.get("arms")
    if isinstance(arms, dict):
        found["arms"] = {
            side: {k: v for k, v in arm.items() if k not in _PLACED} if isinstance(arm, dict) else arm
            for side, arm in arms.items()
        }
    return found


def _flat(value: Any, place: str = "") -> dict[str, Any]:
    if isinstance(value, dict):
        pairs = [(f"{place}.{key}" if place else str(key), one) for key, one in value.items()]
    elif isinstance(value, list):
        pairs = [(f"{place}[{k}]", one) for k, one in enumerate(value)]
    else:
        return {place: value}
    return {key: one for at, inner in pairs for key, one in _flat(inner, at).items()}


def _short(value: Any) -> str:
    text = "not there" if value is None else str(value)
    return text if len(text) < 60 else f"{text[:57]}..."
