"""One table of buttons for all drivers: what the page says, what the drivers do, what C sees."""

import re
import struct
from pathlib import Path

import pytest

from palpate.devices import buttons
from palpate.devices.evdev import Gamepad, Mouse
from palpate.devices.keyboard import Keyboard
from palpate.devices.native import header_folder

PAGE = Path(__file__).parents[2] / "docs" / "device-pairs.md"


def event(code, value):
    return struct.pack("llHHi", 1700000000, 0, 1, code, value)


@pytest.mark.parametrize(
    ("made", "codes"),
    [(Mouse, {0x111: 1, 0x112: 2}), (Gamepad, {0x136: 1, 0x137: 2, 0x130: 4}), (Keyboard, {46: 1, 47: 2, 45: 4})],
    ids=["mouse", "gamepad", "keyboard"],
)
def test_buttons_of_event_devices_give_the_bits_of_the_table(pipe, made, codes):
    path, writer = pipe
    driver = made(path)
    driver.open()
    held = 0
    for code, bit in codes.items():
        writer.write(event(code, 1))
        held |= bit
        assert driver.read().buttons == held
    for code, bit in codes.items():
        if made is Keyboard:  # its keys press and release in turns
            writer.write(event(code, 0))
        writer.write(event(code, 1 if made is Keyboard else 0))
        held &= ~bit
        assert driver.read().buttons == held
    driver.close()


def test_the_page_shows_the_table():
    columns = ("clutch", "gripper", "camera", "coag")
    rows = re.findall(r"^\| `([^`]+)`[^|]*\|(.*)\|$", PAGE.read_text(), re.M)
    shown = {name: [cell.strip() for cell in cells.split("|")] for name, cells in rows}
    for name, table in buttons.TABLE.items():
        for cell, what in zip(shown[name], columns, strict=True):
            button = next((key for key, does in table.items() if does == what), None)
            assert cell in ("-", "its own gripper") if button is None else button in cell, (name, what, cell)


def test_own_buttons_have_bits_and_names_of_their_crtk_nodes():
    pressed = {"0": True, "1": False, "2": False, "3": True}
    assert buttons.bits(pressed, "force-dimension") == buttons.CLUTCH | 0x900
    assert buttons.own_names(None, "haply:id=04C3") == ("A", "B", "C")
    assert buttons.own_names(None, "build/openhaptics.so:Left")[:2] == ("button1", "button2")
    assert buttons.own_names(type("Mine", (), {"own_buttons": ("stylus",)})(), "my:Mine") == ("stylus",)
    for name, crtk in buttons.CRTK.items():
        assert len(crtk) >= len(buttons.TABLE.get(name, ())), name


def test_the_bits_are_those_of_driver_h():
    text = (header_folder() / "driver.h").read_text()
    assert f"PALPATE_BUTTON_OWN(i) ({1 << buttons.OWN}u << (i))" in text
    for name, bit in buttons.PEDALS.items():
        assert f"#define PALPATE_BUTTON_{name.upper()} {bit}u" in text
