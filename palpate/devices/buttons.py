"""The buttons of devices: one table for all drivers, and how they reach the console.

A driver gives bits (`Reading.buttons`, `palpate_driver_state.buttons`). The clutch acts in the haptic cycle, on its own
hand alone; the others are pedals of the console, which act on all hands.
"""

from __future__ import annotations

from typing import Final

from palpate.session.console import Console

CLUTCH, CAMERA, COAG = 1, 2, 4
PEDALS: Final = {"clutch": CLUTCH, "camera": CAMERA, "coag": COAG}
"""Bit of each pedal; as PALPATE_BUTTON_... in driver.h."""
TABLE: Final[dict[str, dict[str, str]]] = {
    "haply": {"a": "clutch", "b": "gripper", "c": "coag"},
    "force-dimension": {"0": "clutch", "1": "camera", "2": "coag"},
    "openhaptics.so": {"1": "clutch", "2": "gripper", "3": "camera", "4": "coag"},
    "mouse": {"right": "clutch", "left": "gripper", "middle": "camera"},
    "keyboard": {"C": "clutch", "space": "gripper", "V": "camera", "X": "coag"},
    "webxr": {"squeeze": "clutch", "trigger": "gripper", "upper": "camera", "lower": "coag"},
    "gamepad": {"left shoulder": "clutch", "right trigger": "gripper", "right shoulder": "camera", "lower": "coag"},
}
"""What each button of a driver does: a pedal, or `gripper` for one that closes the jaws."""


def bits(pressed: dict[str, bool], driver: str) -> int:
    """Bits of the buttons of a driver that are pressed, by the names of `TABLE`."""
    return sum(PEDALS.get(TABLE[driver].get(name, ""), 0) for name, down in pressed.items() if down)


def press(console: Console, before: int, now: int, source: str) -> int:
    """Tell the console the pedals whose bits have changed, but the clutch, which acts in the cycle; returns `now`."""
    for pedal, bit in PEDALS.items():
        if bit != CLUTCH and (before ^ now) & bit:
            console.set(pedal, bool(now & bit), source)
    return now
