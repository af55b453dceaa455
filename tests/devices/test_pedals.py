"""Foot switches and other event devices as pedals, by event streams in the kernel's binary format in a pipe."""

import struct
import time

import pytest

from palpate.base.errors import DeviceError
from palpate.session.console import PEDALS, Console
from palpate.session.pedals import KINDS, PedalDevice, parse

KEY = 1


def events(*rows):
    return b"".join(struct.pack("llHHi", 1700000000, i, *row) for i, row in enumerate(rows))


class Hand:
    def __init__(self):
        self.values = {}

    def change(self, **values):
        self.values |= values

    def request(self, request):
        raise AssertionError(request)


def until(condition):
    end = time.monotonic() + 5.0
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    assert condition()


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_of_every_kind_presses_and_releases_its_pedal(pipe, kind):
    path, writer = pipe
    console = Console([Hand()])
    with PedalDevice(console, f"{kind}:{path}"):
        for code, pedal in KINDS[kind][1].items():
            writer.write(events((KEY, code, 1), (0, 0, 0)))
            until(lambda pedal=pedal: console.pedals[pedal])
            writer.write(events((KEY, code, 2), (KEY, 999, 1), (3, code, 0)))  # repeats and others change nothing
            writer.write(events((KEY, code, 0)))
            until(lambda pedal=pedal: not console.pedals[pedal])
    writer.close()


def test_events_may_be_cut_anywhere(pipe):
    path, writer = pipe
    hand = Hand()
    console = Console([hand])
    with PedalDevice(console, f"footswitch:{path}") as device:
        data = events((KEY, 30, 1), (KEY, 48, 1), (KEY, 30, 0))
        for k in range(0, len(data), 7):
            device.take(data[k : k + 7])
        assert console.pedals["camera"]
        assert not console.pedals["clutch"]
        assert hand.values["camera"] is True
    assert not console.pedals["camera"], "released with the device"
    writer.close()


def test_an_unplugged_foot_switch_keeps_the_clutch_and_takes_presence_away(pipe):
    path, writer = pipe
    console = Console([Hand()])
    device = PedalDevice(console, f"footswitch:{path}:30=clutch,31=operator")
    assert not console.present, "absent until the key is down"
    writer.write(events((KEY, 30, 1), (KEY, 31, 1)))
    until(lambda: console.present and console.pedals["clutch"])
    writer.close()
    until(lambda: device.lost)
    assert "unplugged" in device.lost
    assert console.pedals["clutch"]
    assert not console.present


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("wheel:/dev/x", "there are no pedals 'wheel'"),
        ("footswitch:/dev/x:30=brake", "there is no pedal 'brake'\n  mend: pedals: clutch"),
        ("footswitch:/dev/x:a=clutch", "'a=clutch' is no key with its pedal"),
        ("footswitch:/dev/x:30", "'30' is no key with its pedal"),
        ("footswitch:/dev/input/none", "/dev/input/none cannot be opened"),
    ],
)
def test_wrong_devices_are_refused(spec, words):
    with pytest.raises(DeviceError, match=words):
        PedalDevice(Console([Hand()]), spec)


def test_keys_name_known_pedals():
    for kind, (_, keys) in KINDS.items():
        assert parse(kind) == (kind, "", keys)
        assert set(keys.values()) <= set(PEDALS)
