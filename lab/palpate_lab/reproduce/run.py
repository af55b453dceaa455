"""Makes items one after another, and keeps each in its folder, so that an interrupted run is taken up again.

The folder of an item has ``result.json``, which is written last and in one step: an item with it is complete. It also
holds the key of what made it (sources, seed, versions); an item with another key is made anew.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

from palpate.base import cache as disk_cache
from palpate.base.arrays.plain import finite, plain
from palpate.base.errors import MissingExtraError, OutputError, PalpateError
from palpate_lab.reproduce.catalogue import items
from palpate_lab.reproduce.item import VERDICTS, Drawing, Item, Outcome, Work

RESULT = "result.json"
_DPI = 130  # of the PNG pictures


@dataclass(frozen=True)
class Made:
    """An item on disk."""

    name: str
    result: dict[str, Any]
    """verdict, value, paper, why, and the files with their captions."""
    kept: bool
    """True if it was made by an earlier run."""
    wall_s: float
    cpu_s: float


def make(name: str, folder: Path, seed: int, workers: int | None = None, again: bool = False) -> Made:
    """Make an item, or read what an earlier run left of it.

    Args:
        name: of the item.
        folder: folder of all items; the item gets one of its own.
        seed: of all random numbers.
        workers: processes of sweeps; None: one per core.
        again: make it anew even if it is complete.

    Raises:
        OutputError: the folder cannot be written.
    """
    item, key, place = items()[name], source_key(seed), folder / name
    if not again and (kept := _read(place, key)) is not None:
        return Made(name, kept, True, 0.0, 0.0)
    began, spent = time.perf_counter(), _cpu()
    with tempfile.TemporaryDirectory(prefix=f"palpate-{name}-", ignore_cleanup_errors=True) as scratch:
        outcome = _outcome(item, Work(seed, Path(scratch), workers))
    result = _result(item, outcome)
    try:
        _write(place, outcome, result | {"key": key})
    except OSError as error:
        why = error.strerror or str(error)
        raise OutputError("the item cannot be written", where=str(place), why=why, mend="use --out") from None
    return Made(name, result, False, time.perf_counter() - began, _cpu() - spent)


def make_all(
    names: Sequence[str],
    folder: Path,
    seed: int,
    workers: int | None = None,
    again: bool = False,
    on_item: Callable[[Made], object] = lambda made: None,
    on_start: Callable[[str], object] = lambda name: None,
) -> list[Made]:
    """Make several items, in the given order; `on_start` and `on_item` are called before and after each."""
    found = []
    for name in names:
        on_start(name)
        found.append(make(name, folder, seed, workers, again))
        on_item(found[-1])
    return found


@cache
def source_key(seed: int) -> str:
    """Key of results: all Python sources, the compiled core, the shipped scenes, versions and the seed."""
    from palpate.base.sweep.work import identity
    from palpate.scene import shipped

    scenes = shipped.folder()
    files = sorted(scenes.glob("*.yaml")) if scenes is not None else []
    return disk_cache.source_key(files, identity(), seed)


def _outcome(item: Item, work: Work) -> Outcome:
    """The outcome of an item; one that misses a program or package says so, and the others are made."""
    try:
        return item.make(work)
    except MissingExtraError as error:
        return _absent(item, f"{error.what}: {error.mend}")
    except ModuleNotFoundError as error:
        return _absent(item, f"the package {error.name} is not installed")
    except PalpateError as error:
        return _absent(
            item, f"{error.what}{f' ({error.why})' if error.why else ''}{f': {error.mend}' if error.mend else ''}"
        )


def _absent(item: Item, why: str) -> Outcome:
    return Outcome("not made", {}, item.claim, f"Not made here: {why}.")


def _result(item: Item, outcome: Outcome) -> dict[str, Any]:
    assert outcome.verdict in VERDICTS
    drawn = [
        {"file": file, "caption": drawing.caption} for drawing in outcome.drawings for file in _names(item, drawing)
    ]
    result = {
        "title": item.title, "section": item.section, "claim": item.claim, "reading": item.reading,
        "later": item.later, "rows": item.rows, "code": item.code,
        "verdict": outcome.verdict, "value": outcome.value, "paper": outcome.paper, "why": outcome.why,
        "pictures": drawn, "data": f"{item.name}.csv" if outcome.data else None, "table": outcome.table,
        "lacks": outcome.lacks,
    }  # fmt: skip
    return dict(finite(plain(result)))


def _names(item: Item, drawing: Drawing) -> tuple[str, str]:
    stem = f"{item.name}-{drawing.name}" if drawing.name else item.name
    return f"{stem}.png", f"{stem}.svg"


def _write(place: Path, outcome: Outcome, result: dict[str, Any]) -> None:
    """Write the files of an item into a new folder, and put it in the place of the old one."""
    place.parent.mkdir(parents=True, exist_ok=True)
    new = place.with_name(f".{place.name}.{os.getpid()}")
    shutil.rmtree(new, ignore_errors=True)
    new.mkdir()
    try:
        for drawing, pair in zip(outcome.drawings, _pairs(result["pictures"]), strict=True):
            for file, data in zip(pair, _drawn(drawing), strict=True):
                (new / file).write_bytes(data)
        if outcome.data:
            (new / result["data"]).write_text(_csv(outcome), encoding="utf-8")
        (new / RESULT).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        shutil.rmtree(place, ignore_errors=True)
        new.rename(place)
    finally:
        shutil.rmtree(new, ignore_errors=True)


def _pairs(pictures: Sequence[dict[str, str]]) -> list[tuple[str, str]]:
    return [(a["file"], b["file"]) for a, b in zip(pictures[::2], pictures[1::2], strict=True)]


def _drawn(drawing: Drawing) -> tuple[bytes, bytes]:
    """The picture as PNG and as SVG; the same values give the same bytes."""
    from palpate.base.plotting.style import CANVASES, style

    found = []
    with style():
        for kind in ("png", "svg"):
            stream = BytesIO()
            metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
            drawing.draw(CANVASES[-1]).savefig(stream, format=kind, dpi=_DPI, metadata=metadata)
            found.append(stream.getvalue())
    return found[0], found[1]


def _csv(outcome: Outcome) -> str:
    stream = StringIO()
    rows = [dict(plain(row)) for row in outcome.data]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    writer = csv.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def _read(place: Path, key: str) -> dict[str, Any] | None:
    """The result of a complete item with this key; None if it must be made.

    An item that lacked a program or package is tried anew each time.
    """
    try:
        result = json.loads((place / RESULT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(result, dict) or result.pop("key", None) != key:
        return None
    if result.get("verdict") == "not made" or result.get("lacks"):
        return None
    files = [one["file"] for one in result["pictures"]] + ([result["data"]] if result["data"] else [])
    return result if all((place / file).is_file() for file in files) else None


def _cpu() -> float:
    """Processor time of this process and its ended children [s]."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system
