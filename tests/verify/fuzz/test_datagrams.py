"""A short run of `palpate fuzz datagrams`, and proof that its judges can fail."""

import json

import pytest

from palpate.cli import main

pytest.importorskip("cryptography", reason="links need the extra remote")
from palpate.session.network import channel as channels
from palpate_lab.verify.fuzz import FaultError, datagrams


def test_no_packet_of_a_stranger_is_accepted():
    total: dict[str, int] = {}
    for seed in range(24):
        for name, n in datagrams.case(seed).items():
            total[name] = total.get(name, 0) + n
    assert min(total[kind] for kind in datagrams.KINDS) > 500
    assert 0 < total["decoded"] < total["authentic"]


@pytest.mark.long
def test_a_million_packets_by_the_command(tmp_path):
    file = tmp_path / "d.json"
    assert main(["fuzz", "datagrams", "--cases", "1000000", "--json", str(file)]) == 0
    found = json.loads(file.read_text())
    assert found["runs"] == 1000
    assert found["faults"] == []


@pytest.mark.parametrize(
    ("method", "kind"), [("_window", "replayed"), ("_session", "other session")]
)  # an end that forgets numbers, and one that takes any session
def test_planted_mistakes_of_an_end_are_found(method, kind, monkeypatch):
    class Forgets:
        def accept(self, number):
            return True

    made = channels.Opener.__init__

    def planted(self, key, session):
        made(self, key, session)
        if method == "_window":
            self._window = Forgets()

    monkeypatch.setattr(channels.Opener, "__init__", planted)
    if method == "_session":
        monkeypatch.setattr(channels.Opener, "open", _any)
    with pytest.raises(FaultError, match=f"a packet was accepted: {kind}"):
        several()


def several():
    for seed in range(4):
        datagrams.case(seed)


def _any(opener, data):
    """Opens packets of every session, as an end that does not compare them."""
    if len(data) < 36:
        return None
    opener._session = data[4:12]
    payload = opener._payload(data)
    opener.refused += payload is None
    return payload


def test_a_number_of_messages_belongs_to_two_targets():
    assert main(["fuzz", "files", "--cases", "10"]) == 2
