"""What a session of registration and its check print and write."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from palpate.cli.terminal.output import say, write_text

if TYPE_CHECKING:
    from palpate.base.arrays import Array
    from palpate.scene.registered import RegisteredOrgan
    from palpate.scene.registration import RegistrationSection
    from palpate.world.registration.procedure import Procedure
    from palpate.world.registration.touch_check import TouchCheck


def now() -> str:
    """The present date as files state it."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def lines_of_targets(procedure: Procedure) -> list[str]:
    """One line per target: the predicted error, and its bound."""
    bounds = procedure.bounds
    return [
        f"TRE at {name}: {1e3 * one.tre:.2f} mm rms, below {1e3 * bounds[name]:.2f} mm with 95 %, largest along "
        f"({', '.join(f'{x:+.2f}' for x in one.direction)})"
        for name, one in procedure.targets.items()
    ]


def progress(console: Console, given: RegistrationSection, procedure: Procedure) -> None:
    """Print the state after the first pose, or after a touch."""
    n, worst = len(procedure.X_WT), 1e3 * max(procedure.bounds.values())
    label = "first pose:" if n == 0 else f"touch {n}:"
    rest = f", {1e3 * procedure.found.residuals[-1]:+.2f} mm from the surface" if n else ""
    say(console, f"targets known within {worst:.2f} mm{rest}", label)
    if n == 0:
        _outlook(console, given, procedure)


def _outlook(console: Console, given: RegistrationSection, procedure: Procedure) -> None:
    """Print which motion of the organ the session will tell, before its first touch."""
    later = procedure.foreseen(given.touches)
    if later is not None:
        size = f"{1e3 * later.smallest_motion:.1f} mm"
        words = f"{len(later.X_WT)} touches, which tell a motion of the organ from {size} on (9 of 10 times)"
        say(console, words, "expected:")
    if procedure.view is not None:
        size = f"{1e3 * procedure.smallest_motion_seen:.1f} mm"
        say(console, f"a last view, which tells a motion since the first from {size} on (9 of 10 times)", "expected:")


def values(scanned: RegisteredOrgan, procedure: Procedure, sources: list[str]) -> dict[str, Any]:
    """The result in plain values: pose of the registered frame in the world, and errors at the targets."""
    import numpy as np

    from palpate.base.arrays.plain import finite, plain
    from palpate.base.arrays.rigid import composed_covariance, inverse, transform

    found, X_OA = procedure.found, inverse(scanned.X_AO)
    bounds = procedure.bounds
    targets = []
    for name, one in procedure.targets.items():
        p_A = transform(scanned.X_AO, one.p[None])[0]
        targets.append({"name": name, "within": bounds[name], **plain(one), "p": p_A.tolist()})
    result: dict[str, Any] = finite(plain({
        "method": "session", "date": now(), "sources": sources, "X": found.X @ X_OA,
        "covariance": composed_covariance(found.X, found.covariance, X_OA, np.zeros((6, 6))),
        "fre": float(np.sqrt(np.square(found.residuals).mean())), "tre": [one["tre"] for one in targets],
        "targets": targets, "accuracy": procedure.accuracy, "touches": len(procedure.X_WT),
        "probability": found.probability, "trusted": procedure.met, "smallest_motion": procedure.smallest_motion,
        "smallest_motion_seen": procedure.smallest_motion_seen,
    }))  # fmt: skip
    return result


def write(path: Path, data: dict[str, Any]) -> None:
    """Write a result as YAML."""
    import yaml

    write_text(path, yaml.safe_dump(data, sort_keys=False))


def lines_of_check(found: TouchCheck) -> list[str]:
    """The check in words: one line per place, mean and worst."""

    def words(v: Array) -> str:
        return ", ".join(f"{x:+.2f}" for x in v)

    return [
        *(f"place {k + 1}: felt {1e3 * d:+.2f} mm along ({words(n)})"
          for k, (d, n) in enumerate(zip(found.distances, found.normals, strict=True))),
        f"felt against predicted contact: mean {1e3 * found.mean:.2f} mm, worst {1e3 * found.worst:.2f} mm along "
        f"({words(found.direction)})",
    ]  # fmt: skip


def values_of_check(found: TouchCheck) -> dict[str, Any]:
    """The check in plain values."""
    from palpate.base.arrays.plain import finite, plain

    result: dict[str, Any] = finite(plain(found))
    return {"date": now(), "passed": found.passed, **result}
