"""Traits of the simulated operators, their sources, and their distribution over a cohort.

How certain are the numbers? The sources measured people in other experiments with other handles. The medians here are
round numbers within the reported ranges, and the spreads cover those ranges. If no number is published for a trait, its
source says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.arm.hands import PRESETS, Hand

GRIPS = ("light", "normal", "firm")
"""Hand presets (`palpate.arm.hands`) of a cohort; each hand is drawn within a factor of two of its preset."""


@dataclass(frozen=True)
class Trait:
    """Distribution of one trait over a cohort."""

    median: float
    factor: float
    """Spread (log-normal): 95 % of the cohort lie between median / factor and median * factor."""
    unit: str
    doc: str
    source: str


#: All traits that differ between the simulated operators, in addition to their hands.
TRAITS: dict[str, Trait] = {
    "pace": Trait(
        0.12, 1.6, "s", "time per length of path, for a length equal to the width of the passage",
        "steering law T = b L / W: Accot and Zhai 1997, Beyond Fitts' law; slopes of 0.06 to 0.2 s by path and device",
    ),
    "visual_delay": Trait(
        0.16, 1.3, "s", "delay from the picture to the hand's correction",
        "Saunders and Knill 2005: 117 ms across the motion, 130 to 200 ms along it; Brenner and Smeets 2003; a display "
        "adds some ten ms",
    ),
    "visual_gain": Trait(
        3.0, 1.5, "1/s", "speed of correction per seen error",
        "crossover model, McRuer and Jex 1967: crossover at 3 to 5 rad/s; lower where care matters more than speed",
    ),
    "visual_error": Trait(
        0.4e-3, 1.8, "m", "rms error of the seen tool position across the line of sight, slowly varying",
        "microsurgeons under a microscope err by 0.14 to 0.29 mm in space (Singh, Riviere and others 2013); an "
        "endoscope shows less. Order of magnitude sure, number ours",
    ),
    "depth": Trait(
        2.0, 1.5, "", "error along the line of sight per error across it",
        "stereo depth is less certain than direction: Saunders and Knill 2005 explain the slower corrections in depth "
        "by it. Number ours",
    ),
    "noise": Trait(
        0.15, 1.5, "", "rms of the signal-dependent motor noise per intended speed",
        "Harris and Wolpert 1998; van Beers, Haggard and Wolpert 2004 measured about a tenth, and a part that does not "
        "depend on the signal",
    ),
    "unrest": Trait(
        1.0e-3, 1.6, "m/s", "rms of the motor noise of a hand at rest",
        "eye surgeons who hold still: slow wander, range 0.2 mm (Riviere, Rader and Khosla 1997), several times that "
        "without a rest for the wrist (Coulson, Slack and Ma 2010)",
    ),
    "tremor": Trait(
        0.06e-3, 2.0, "m", "rms of the tremor at 8 to 12 Hz, per axis",
        "50 to 200 um rms at a hand-held instrument (review in Singh, Riviere and others 2013); 38 um in the most "
        "delicate part of eye surgery (Riviere and others)",
    ),
    "touch_delay": Trait(
        0.10, 1.3, "s", "delay from a force on the hand to the intended response",
        "long-latency responses 50 to 105 ms, voluntary ones after that (Pruszynski and Scott 2012)",
    ),
    "weber": Trait(
        0.08, 1.5, "", "rms error of a felt force per force",
        "just noticeable difference 7 % (Pang, Tan and Durlach 1991), 5 to 10 % elsewhere (Jones 1989)",
    ),
    "threshold": Trait(
        0.04, 1.6, "N", "smallest force that is felt",
        "some ten mN for forces of a haptic device (Dosher and Hannaford 2005)",
    ),
    "sight_of_force": Trait(
        0.35, 1.4, "", "relative spread of a force judged by the look of the tissue; one bias per trial",
        "people misjudge forces by sight, and better after training with touch (Chua, Jarc, Wren, Nisky and Okamura "
        "2023). Number ours",
    ),
    "haste": Trait(
        1.2, 1.2, "", "force aimed at without force feedback, per intended force",
        "without force feedback mean forces are at least 1.5 times as large, peaks twice (Wagner, Stylopoulos, Jackson "
        "and Howe 2007): the part that the closed loop does not explain. Number ours",
    ),
    "yields": Trait(
        0.8, 2.5, "1/s", "rate at which the hand gives way to a lasting force, relative to its own spring",
        "people asked to relax give way, asked to resist they stiffen: Abbink, Mulder, van der Helm and others 2011. "
        "Number ours",
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Person:
    """Traits (`TRAITS`) and hand of one simulated operator."""

    number: int
    hand: Hand
    pace: float
    visual_delay: float
    visual_gain: float
    visual_error: float
    depth: float
    noise: float
    unrest: float
    tremor: float
    touch_delay: float
    weber: float
    threshold: float
    sight_of_force: float
    haste: float
    yields: float
    care: float = 1.0
    """Share by which an operator slows down for an error that is seen; 0: the speed does not depend on it [-]."""


def cohort(n: int, seed: int = 7) -> list[Person]:
    """Draw n simulated operators; operator i does not depend on n.

    Args:
        n: number of operators.
        seed: seed of the whole cohort.
    """
    return [person(i, seed) for i in range(n)]


def person(number: int, seed: int = 7) -> Person:
    """Draw one operator of a cohort, by number."""
    rng = np.random.default_rng([seed, number])
    drawn = {name: t.median * t.factor ** float(rng.normal() / 1.96) for name, t in TRAITS.items()}
    drawn["haste"] = max(drawn["haste"], 1.0)
    hand = PRESETS[GRIPS[int(rng.integers(len(GRIPS)))]].drawn(rng)
    return Person(number, hand, **drawn)
