"""The buttons of devices: one table for all drivers, and how they reach the console.

A driver gives bits (`Reading.buttons`, `palpate_driver_state.buttons`). The clutch acts in the haptic cycle, on its own
hand alone; the others are pedals of the console (`palpate.session.pedals.press`), which act on all hands.
"""

from __future__ import annotations

from typing import Final

CLUTCH, CAMERA, COAG = 1, 2, 4
PEDALS: Final = {"clutch": CLUTCH, "camera": CAMERA, "coag": COAG}
"""Bit of each pedal; as PALPATE_BUTTON_... in driver.h."""
TABLE: Final[dict[str, dict[str, str]]] = {
    "haply": {"a": "clutch", "b": "gripper", "c": "coag"},
    "force-dimension": {"0": "clutch", "1": "camera", "2": "coag", "3": "gripper"},
    "force_dimension.so": {"0": "clutch", "1": "camera", "2": "coag", "3": "gripper"},
    "openhaptics.so": {"1": "clutch", "2": "gripper", "3": "camera", "4": "coag"},
    "novint.so": {"1": "clutch", "2": "gripper", "3": "camera", "4": "coag"},
    "mouse": {"right": "clutch", "left": "gripper", "middle": "camera"},
    "keyboard": {"C": "clutch", "space": "gripper", "V": "camera", "X": "coag"},
    "webxr": {"squeeze": "clutch", "trigger": "gripper", "upper": "camera", "lower": "coag"},
    "gamepad": {"left shoulder": "clutch", "right trigger": "gripper", "right shoulder": "camera", "lower": "coag"},
}
"""What each button of a driver does: a pedal, or `gripper` for one that closes the jaws."""
OWN: Final = 8
"""The bit of a device's own first button: bit OWN + i is its button i as it is, whatever it does; as in driver.h."""
CRTK: Final[dict[str, tuple[str, ...]]] = {
    "haply": ("A", "B", "C"),
    "force-dimension": ("center", "left", "top", "right"),
    "force_dimension.so": ("center", "left", "top", "right"),
    "novint.so": ("center", "left", "top", "right"),
    "openhaptics.so": ("button1", "button2", "button3", "button4"),
}
"""Own buttons of a device, in the order of their bits, as its node of the CRTK family (sawHaplyService,
sawForceDimensionSDK, sawSensablePhantom) names their topics; the four names of Force Dimension are a Falcon's."""


def own_names(driver: object, name: str) -> tuple[str, ...]:
    """Names of a device's own buttons: those of its CRTK node, else those that its class states as `own_buttons`."""
    stated = getattr(driver, "own_buttons", ())
    file = name.partition(":")[0].rpartition("/")[2]
    return CRTK.get(file, tuple(map(str, stated)))


def bits(pressed: dict[str, bool], driver: str) -> int:
    """Bits of the buttons of a driver that are pressed, by the names of `TABLE`: what they do, and their own."""
    table = TABLE[driver]
    acts = sum(PEDALS.get(table.get(name, ""), 0) for name, down in pressed.items() if down)
    return acts | sum(1 << OWN + i for i, name in enumerate(table) if pressed.get(name))
