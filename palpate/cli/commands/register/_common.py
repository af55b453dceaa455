"""Options and output that all registration commands share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Protocol

from rich.console import Console
from tyro.conf import arg

from palpate.base.errors import RegistrationError, refuse_to_overwrite
from palpate.cli.terminal.output import console_for, require_writable, say, write_json, write_text

if TYPE_CHECKING:
    from palpate.base.arrays import Array


class _WithOutliers(Protocol):
    @property
    def residuals(self) -> Array:
        """(N,) [m]."""
        ...

    @property
    def outliers(self) -> tuple[int, ...]:
        """Measurements that were left out."""
        ...


@dataclass(kw_only=True)
class Register:
    """Base class of a registration command."""

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the result as JSON (docs/json.md); - for the standard output."""
    out: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Write the pose with its covariance, source, date and errors."""
    force: bool = False
    """Overwrite an existing file."""
    unit: Literal["m", "mm"] = "m"
    """Unit of lengths in the files whose columns do not name one."""

    def begin(self) -> Console:
        """Check that the files can be written, before anything is computed; returns the console."""
        if self.out is not None:
            refuse_to_overwrite(self.out, self.force)
            require_writable(self.out)
        require_writable(self.json)
        return console_for(self.json)

    def finish(self, console: Console, lines: Sequence[str], values: dict[str, Any], sources: Sequence[Path]) -> None:
        """Print the result, write the pose and the JSON.

        Args:
            console: for messages.
            lines: the result in words; the errors at the targets and the warnings are added.
            values: keys of docs/json/register.md in plain values.
            sources: files of the measurements.
        """
        import yaml

        for line in [*lines, *lines_of_targets(values)]:
            say(console, line)
        for text in values.get("warnings", ()):
            say(console, text, "warning:", "yellow")
        if self.out is not None:
            stamp = datetime.now(UTC).isoformat(timespec="seconds")
            head = {"method": values["method"], "date": stamp, "sources": [str(path) for path in sources]}
            kept = {key: values[key] for key in _KEPT if key in values}
            write_text(self.out, yaml.safe_dump(head | kept, sort_keys=False))
            say(console, str(self.out), "pose:")
        write_json(self.json, values)


_KEPT = ("X", "p_TQ", "covariance", "fre", "fle", "tre", "targets", "outliers", "trusted", "doubts", "accepted")


def values_of(method: str, result: object, names: Sequence[str] = ()) -> dict[str, Any]:
    """Fields of a result in plain values, None in place of numbers that are not finite, targets with their names."""
    from palpate.base.arrays.plain import finite, plain

    values: dict[str, Any] = {"method": method, **finite(plain(result))}
    for name, one in zip(names, values.get("targets", ()), strict=False):
        one["name"] = name
    return values


def targets(texts: Sequence[str]) -> tuple[list[str], Array | None]:
    """Names and positions (K, 3) of targets given as x,y,z or name=x,y,z [m]; None without targets.

    Raises:
        RegistrationError: not three numbers.
    """
    import numpy as np

    names, places = [], []
    for i, text in enumerate(texts):
        name, _, numbers = text.rpartition("=")
        try:
            place = [float(x) for x in numbers.split(",")]
        except ValueError:
            place = []
        if len(place) != 3:
            raise RegistrationError(f"the target {text!r} is not a place", mend="give x,y,z or name=x,y,z in metres")
        names.append(name or str(i))
        places.append(place)
    return names, np.array(places) if places else None


def lines_of_targets(values: dict[str, Any]) -> list[str]:
    """One line per target: predicted error and its direction."""
    found = []
    for one in values.get("targets", ()):
        direction = ", ".join(f"{x:+.2f}" for x in one["direction"])
        found.append(
            f"TRE at {one['name']}: {1e3 * one['tre']:.3f} mm rms, largest along ({direction}): "
            f"{1e3 * one['semi_axes'][0]:.3f} mm (one standard deviation)"
        )
    return found


def lines_of_wrong(kind: str, found: _WithOutliers) -> list[str]:
    """One line per measurement that was left out."""
    return [f"wrong {kind}: row {i + 1}, {1e3 * found.residuals[i]:.2f} mm; not used" for i in found.outliers]


def lines_of_pose(X: list[list[float]]) -> list[str]:
    """The rows of a pose."""
    return ["  " + " ".join(f"{x:+.6f}" for x in row) for row in X]
