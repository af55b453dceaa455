"""The simulated operator's hand on the handle: presets from relaxed to rigid with their sources, and fitted hands.

A hand is a mass fixed to the handle, and a spring and damper from the mass to the person's intended path:

    F_arm_on_hand = m x_tt + b (x_t - x_path_t) + k (x - x_path)

The second-order model suits small motions around a steady grip, up to about 30 Hz (Hajian and Howe 1997; Hasser and
Cutkosky 2002). A better fit over a wider band takes five parameters (Speich, Shao and Goldfarb 2005).

How certain are the numbers? The sources measured that stiffness and damping grow with the grip, hence the order of the
presets. The magnitudes lie within the reported ranges. The numbers are our own round values: no source reports this
grip on this arm, and people differ by a factor of two. The model is isotropic. Real arms at rest are several times
stiffer along one direction than across it (Mussa-Ivaldi, Hogan and Bizzi 1985), but that direction depends on the
posture. `palpate calibrate hand` identifies your own hand.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np
import yaml

from palpate import _core
from palpate.base.arrays.yaml_loader import read_yaml
from palpate.base.errors import OutputError, RecordingError

_KEYS = ("mass", "damping", "stiffness")
_DEFAULT = _core.HandOptions()


@dataclass(frozen=True)
class Hand:
    """A hand as a mechanical impedance, equal along all directions."""

    name: str
    mass: float
    """Mass fixed to the handle [kg]."""
    damping: float
    """Damping between the hand and its intended path [N s/m]."""
    stiffness: float
    """Stiffness between the hand and its intended path [N/m]."""
    grip: str = ""
    """Description of the grip."""
    source: str = ""
    """Source of the numbers, and their certainty."""

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: a number is not positive; the message names it.
        """
        for key in _KEYS:
            value = getattr(self, key)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < 1e5:
                raise ValueError(f"{key} must be a number above 0. Got: {value!r}")

    def options(self) -> _core.HandOptions:
        """Options for the core; the rotational values are the core's defaults."""
        o = _core.HandOptions()
        o.mass, o.damping, o.stiffness = self.mass, self.damping, self.stiffness
        return o

    def damped(self, factor: float) -> Self:
        """The same hand with `factor` times its damping."""
        return replace(self, damping=factor * self.damping)

    def drawn(self, rng: np.random.Generator, factor: float = 2.0) -> Self:
        """A random hand in the same grip: each number is log-normal, and 95 % lie within `factor` of this hand's."""
        m, b, k = np.exp(rng.normal(0.0, np.log(factor) / 1.96, 3)).tolist()
        return replace(self, mass=m * self.mass, damping=b * self.damping, stiffness=k * self.stiffness)

    def save(self, path: str | Path, notes: Mapping[str, object] | None = None) -> None:
        """Write the hand as YAML, for ``operator: {hand: FILE}`` in a scene.

        Raises:
            OutputError: the file cannot be written.
        """
        data = {"kind": "hand", **{k: v for k, v in asdict(self).items() if v != ""}, "notes": dict(notes or {})}
        text = f"# A hand; in a scene: operator: {{hand: {Path(path).name}}}\n" + yaml.safe_dump(data, sort_keys=False)
        try:
            Path(path).write_text(text, encoding="utf-8")
        except OSError as error:
            why = error.strerror or str(error)
            raise OutputError("the file cannot be written", where=str(path), why=why, mend="use --out") from None


_GROWS = (
    "Hasser and Cutkosky 2002 (knob in a pinch, nine people), Kuchenbecker, Park and Niemeyer 2003 (wrist, pen grip): "
    "stiffness and damping grow steadily with the grip force, the inertia does not"
)

#: Hands by name, from the softest to the stiffest.
PRESETS: dict[str, Hand] = {
    hand.name: hand
    for hand in (
        Hand(
            "relaxed", 0.05, 1.5, 50.0, "fingertips let the handle move",
            f"{_GROWS}. Its low end; light pen grips of 1 N and less. Trend sure, numbers ours",
        ),
        Hand(
            "light", 0.10, 5.0, 120.0, "a pinch as for writing, the wrist free",
            f"{_GROWS}; Fu and Cavusoglu 2012 (stylus, 15 people, grips of 1 to 3 N, three axes). Order of magnitude "
            "sure, numbers ours",
        ),
        Hand(
            "normal", _DEFAULT.mass, _DEFAULT.damping, _DEFAULT.stiffness,
            "a pinch that holds the handle where it is wanted, the wrist rested",
            "Palpate's default. A fingertip pressed with 2 N and more has hundreds of N/m and some N s/m (Hajian and "
            "Howe 1997), two of them and a supported wrist move as one. Order of magnitude sure, numbers ours",
        ),
        Hand(
            "firm", 0.30, 15.0, 600.0, "all fingers and the wrist tense",
            "Hajian and Howe 1997: stiffness of a fingertip reaches about a thousand N/m at 20 N; here in series with "
            "the wrist. Order of magnitude sure, numbers ours",
        ),
        Hand(
            "rigid", 0.80, 25.0, 1000.0, "fist and forearm tense, the elbow propped",
            "arms that hold a posture: about 1 kg, some ten N s/m, hundreds of N/m (Mussa-Ivaldi, Hogan and Bizzi "
            "1985; Dolan, Friedman and Nagurka 1993; Tsuji and others 1995), stiffer when tense. Order of magnitude "
            "sure, numbers ours",
        ),
    )
}  # fmt: skip


def load(path: str | Path) -> Hand:
    """Read a hand that `Hand.save` or ``palpate calibrate hand`` wrote.

    Raises:
        RecordingError: the file cannot be read or does not describe a hand; the message names the missing key.
    """
    try:
        data = read_yaml(Path(path))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        why = getattr(error, "strerror", None) or str(error).partition("\n")[0]
        raise RecordingError("the hand cannot be read", where=str(path), why=why) from None
    try:
        if data["kind"] != "hand":
            raise ValueError(f"its kind is {data['kind']!r}")
        name, grip, source = (str(data.get(key, "")) for key in ("name", "grip", "source"))
        return Hand(name or Path(path).stem, data["mass"], data["damping"], data["stiffness"], grip, source)
    except (KeyError, TypeError, ValueError) as error:
        raise RecordingError(
            "the file does not describe a hand",
            where=str(path),
            why=f"{error} is missing" if isinstance(error, KeyError) else str(error),
            mend="write one with palpate calibrate hand",
        ) from None
