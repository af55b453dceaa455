"""Devices at USB, pedals, services and ports."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from palpate.cli.doctor.finding import Finding

DEVICES = {
    ("1451", ""): "Force Dimension",
    ("0403", "cb48"): "Novint Falcon",
    ("2988", ""): "3D Systems Touch",
}
"""Vendor and product of haptic devices at USB; an empty product is any of the vendor's."""
PORTS = {8080: "the viewer", 18944: "OpenIGTLink"}
"""Default ports on which commands listen."""
HAPLY = 10001
"""Port of Haply's service."""
_USB = Path("/sys/bus/usb/devices")
_RULE = "/etc/udev/rules.d/70-palpate.rules"


def usb(devices: Path = _USB, nodes: Path = Path("/dev/bus/usb")) -> list[Finding]:
    """Haptic devices at USB, and whether this user may use them.

    Args:
        devices: folder in which the system lists what is plugged in.
        nodes: folder of the device files, ``BUS/DEVICE``.
    """
    found = []
    for folder in sorted(devices.glob("*")):
        vendor, product = _word(folder / "idVendor"), _word(folder / "idProduct")
        name = DEVICES.get((vendor, product)) or DEVICES.get((vendor, ""))
        if name is None:
            continue
        node = nodes / f"{int(_word(folder / 'busnum')):03d}" / f"{int(_word(folder / 'devnum')):03d}"
        allowed = os.access(node, os.R_OK | os.W_OK)
        rule = f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{vendor}", MODE="0666"'
        fix = "" if allowed else f"echo '{rule}' | sudo tee {_RULE}; sudo udevadm control --reload; plug it in again"
        words = f"{vendor}:{product}, {'may be used' if allowed else f'no right to write {node}'}"
        found.append(Finding("USB", name, "ok" if allowed else "problem", words, "this device", fix))
    if found:
        return found
    names = ", ".join(DEVICES.values())
    return [
        Finding(
            "USB", "haptic devices", "optional", f"none of {names}", "a device at USB", "plug it in, if you have one"
        )
    ]


def inputs(folder: Path = Path("/dev/input")) -> list[Finding]:
    """Foot switches, gamepads and mice: may this user read them?"""
    events = sorted(folder.glob("event*"))
    needed = "foot switches, gamepads, mice as pedals or devices"
    closed = [event for event in events if not os.access(event, os.R_OK)]
    if not events:
        return [Finding("inputs", "events", "optional", f"no {folder}/event*", needed, "connect one, if you have one")]
    if closed:
        fix = 'sudo usermod -aG input "$USER", then log in again'
        return [Finding("inputs", "events", "optional", f"{len(closed)} of {len(events)} may not be read", needed, fix)]
    return [Finding("inputs", "events", "ok", f"{len(events)} may be read", needed)]


def devices() -> list[Finding]:
    """Vendors' libraries and services that drivers need."""
    from palpate.devices.libraries import libraries

    found = []
    for one in libraries():
        here = one.found or f"{one.file} in none of {len(one.places)} folders"
        fix = "" if one.found else f"install the {one.product}; palpate device list names the folders"
        found.append(
            Finding("devices", one.product, "ok" if one.found else "optional", here, f"driver {one.driver}", fix)
        )
    runs = _answers(HAPLY)
    words = f"port {HAPLY} {'answers' if runs else 'does not answer'}"
    fix = "" if runs else f"start it, or the stand-in: palpate device stand-in haply --port {HAPLY}"
    found.append(Finding("devices", "Haply's service", "ok" if runs else "optional", words, "driver haply", fix))
    return found


def ports() -> list[Finding]:
    """Are the default ports of servers free?"""
    found = []
    for port, use in PORTS.items():
        taken = _taken(port)
        fix = f"end the other program, or name another port: --port {port + 1}" if taken else ""
        words = f"{port} {'is taken' if taken else 'is free'}"
        found.append(Finding("ports", use, "optional" if taken else "ok", words, f"{use} at its usual port", fix))
    return found


def _word(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""


def _answers(port: int) -> bool:
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=0.2):
            return True
    except OSError:
        return False


def _taken(port: int) -> bool:
    with socket.socket() as one:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            one.bind(("127.0.0.1", port))
        except OSError:
            return True
    return False
