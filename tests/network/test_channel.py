"""Keys, the encrypted channel and the relay: strangers, replays and damaged packets are refused."""

import secrets
import socket
import threading

import numpy as np
import pytest

from palpate import _network
from palpate.base.errors import PalpateError
from palpate.session.network import network
from palpate.session.network.keys import make_key, read_key

pytest.importorskip("cryptography", reason="links need the extra remote")
from palpate.session.network import channel as channels
from palpate.session.network.relay import Relay, listen

KEY, SESSION = secrets.token_bytes(32), secrets.token_bytes(8)


def ends(key=KEY):
    return channels.Sealer(key, SESSION), channels.Opener(key, SESSION)


def test_packets_are_opened_once_and_in_any_order():
    sealer, opener = ends()
    packets = [sealer.seal(bytes([k])) for k in range(100)]
    order = np.random.default_rng(0).permutation(100)
    assert [opener.open(packets[k]) for k in order] == [bytes([k]) for k in order]
    assert all(opener.open(packet) is None for packet in packets)
    assert opener.refused == 100


@pytest.mark.parametrize("count", [20_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_no_forged_replayed_or_truncated_packet_is_accepted(count):
    rng = np.random.default_rng(1)
    sealer, opener = ends()
    other = channels.Sealer(secrets.token_bytes(32), SESSION)
    payload = _network.encode(_network.Datagram())
    true = [sealer.seal(payload) for _ in range(200)]
    assert all(opener.open(packet) == payload for packet in true)
    for k in range(count):
        packet = bytearray(true[k % 200])
        kind = k % 5
        if kind == 0:  # replayed
            pass
        elif kind == 1:  # a bit is flipped
            packet[int(rng.integers(len(packet)))] ^= 1 << int(rng.integers(8))
        elif kind == 2:  # truncated
            del packet[int(rng.integers(len(packet))) :]
        elif kind == 3:  # another key
            packet = bytearray(other.seal(payload))
        else:
            packet = bytearray(rng.bytes(int(rng.integers(0, 400))))
        assert opener.open(bytes(packet)) is None
    assert opener.open(sealer.seal(payload)) == payload


def test_a_packet_of_another_session_with_the_same_key_is_refused():
    sealer = channels.Sealer(KEY, secrets.token_bytes(8))
    assert channels.Opener(KEY, SESSION).open(sealer.seal(b"x")) is None


def shaken(key_a=KEY, key_b=KEY):
    a, b = socket.socketpair()
    found = []
    thread = threading.Thread(target=lambda: found.append(channels.shake_hands(b, key_b, operator=False)))
    thread.start()
    mine = channels.shake_hands(a, key_a, operator=True)
    thread.join()
    return mine, found[0]


def test_both_ends_agree_on_keys_and_each_direction_has_its_own():
    a, b = shaken()
    a.send({"x": 1})
    assert b.receive() == {"x": 1}
    b.send({"y": [1, 2]})
    assert a.receive() == {"y": [1, 2]}
    packet = a.sealer.seal(b"motion")
    assert a.opener.open(packet) is None  # reflected to its sender
    assert b.opener.open(packet) == b"motion"
    a.close()
    assert b.receive() is None


def test_another_key_is_told():
    a, b = shaken(key_b=secrets.token_bytes(32))
    a.send({"x": 1})
    with pytest.raises(channels.RefusedError, match="another key"):
        b.receive()


def test_another_protocol_is_told():
    a, b = socket.socketpair()
    b.sendall(b"GET / HTTP/1.1\r\n" + b"x" * 64)
    with pytest.raises(channels.RefusedError, match="another protocol"):
        channels.shake_hands(a, KEY, operator=True)


def test_keys_are_private_files(tmp_path):
    path = tmp_path / "sub" / "key"
    make_key(path)
    assert len(read_key(path)) == 32
    assert path.stat().st_mode & 0o777 == 0o600
    with pytest.raises(PalpateError, match="exists"):
        make_key(path)
    path.chmod(0o644)
    with pytest.raises(PalpateError, match=r"(?s)others may read this key.*chmod 600"):
        read_key(path)
    (tmp_path / "no").write_text("palpate-remote-key-1 abc\n")
    (tmp_path / "no").chmod(0o600)
    with pytest.raises(PalpateError, match="this is no key"):
        read_key(tmp_path / "no")
    with pytest.raises(PalpateError, match=r"(?s)there is no key.*palpate keys --out"):
        read_key(tmp_path / "missing")
    with pytest.raises(PalpateError, match=r"(?s)cannot be read.*folder"):
        read_key(tmp_path)


@pytest.mark.parametrize(
    "text",
    ["localhost", ":7410", "localhost:", "localhost:x", "localhost:70000", "localhost:²", "localhost:" + 5000 * "9"],
)
def test_a_wrong_address_is_told(text):
    with pytest.raises(PalpateError, match=r"(?s)is no address.*HOST:PORT"):
        channels.address(text)


def test_a_name_that_does_not_resolve_is_told():
    with pytest.raises(PalpateError, match=r"the name 'no-such-host.invalid' does not resolve"):
        channels.address("no-such-host.invalid:7410")
    with pytest.raises(PalpateError, match=r"the name 'a..b' does not resolve"):
        channels.address("a..b:7410")  # Python cannot even encode it
    assert channels.address("127.0.0.1:7410") == ("127.0.0.1", 7410)


def test_a_port_that_is_taken_is_told():
    tcp, udp = listen("127.0.0.1", 0)
    with pytest.raises(PalpateError, match=r"port \d+ of 127.0.0.1 cannot be used"):
        listen("127.0.0.1", tcp.getsockname()[1])
    with pytest.raises(PalpateError, match=r"port 70000 of 127.0.0.1 cannot be used"):
        listen("127.0.0.1", 70000)
    with pytest.raises(PalpateError, match=r"--host no-such-host.invalid: the name does not resolve"):
        listen("no-such-host.invalid", 0)
    with pytest.raises(PalpateError, match=r"--host 192.0.2.1: this machine has no such address"):
        listen("192.0.2.1", 0)
    tcp.close()
    udp.close()


def test_the_relay_passes_packets_on_with_the_delay_of_its_network():
    import time

    link = network("none")
    link.to_site.delay = link.to_operator.delay = 0.03
    tcp, far = listen("127.0.0.1", 0)
    far.setblocking(True)
    far.settimeout(5.0)
    relay = Relay(0, ("127.0.0.1", tcp.getsockname()[1]), link)
    thread = threading.Thread(target=relay.run)
    thread.start()
    near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    near.settimeout(5.0)
    try:
        begin = time.monotonic()
        near.sendto(b"hello", ("127.0.0.1", relay.port))
        data, sender = far.recvfrom(100)
        assert data == b"hello"
        assert time.monotonic() - begin >= 0.029
        far.sendto(b"back", sender)
        assert near.recvfrom(100)[0] == b"back"
        assert time.monotonic() - begin >= 0.058
    finally:
        relay.stop()
        thread.join()
        for each in (tcp, far, near):
            each.close()


def test_a_relay_without_a_follower_ends_the_connection_at_once():
    free = socket.socket()
    free.bind(("127.0.0.1", 0))
    relay = Relay(0, free.getsockname(), network("none"))
    thread = threading.Thread(target=relay.run)
    thread.start()
    try:
        with (
            socket.create_connection(("127.0.0.1", relay.port), 3.0) as near,
            pytest.raises(channels.RefusedError, match=r"(?s)has ended the connection.*running there"),
        ):
            channels.shake_hands(near, KEY, operator=True)
    finally:
        relay.stop()
        thread.join()
        free.close()
