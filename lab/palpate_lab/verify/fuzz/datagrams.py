"""Forged, replayed, truncated and reflected packets at both ends of a link: none may be accepted, nothing may move.

A stranger has recorded true packets and knows the session, but no key. A second kind of case has the key and sends
authentic packets with damaged content: the site may refuse them or follow within its limits, and stays finite.
"""

from __future__ import annotations

import numpy as np

from palpate import _core, _network
from palpate.session.network import channel as channels
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

MESSAGES = 1000
"""Packets of a case."""
_TRUE = 64  # packets that the stranger has recorded
_TICKS = 200  # of the site after authentic packets with damaged content
KINDS = ("replayed", "bit", "truncated", "extended", "other key", "other session", "reflected", "noise", "head")


def case(seed: int) -> dict[str, int]:
    """Show `MESSAGES` packets of a stranger to one end.

    Raises:
        FaultError: one was accepted, a true packet was refused afterwards, or the site's goal broke a limit.
    """
    rng = np.random.default_rng(seed)
    if rng.uniform() < 0.1:
        return _authentic(rng)
    key, back, session = rng.bytes(32), rng.bytes(32), rng.bytes(8)
    sealer, opener = channels.Sealer(key, session), channels.Opener(key, session)
    strangers = (
        channels.Sealer(rng.bytes(32), session),
        channels.Sealer(key, rng.bytes(8)),
        channels.Sealer(back, session),
    )
    payload = _network.encode(_datagram(rng))
    true = [sealer.seal(payload) for _ in range(_TRUE)]
    for packet in true:
        if opener.open(packet) != payload:
            raise FaultError("a true packet was refused")
    counts: dict[str, int] = {}
    for _ in range(MESSAGES):
        kind = KINDS[int(rng.integers(len(KINDS)))]
        counts[kind] = counts.get(kind, 0) + 1
        packet = _forged(kind, rng, true[int(rng.integers(_TRUE))], payload, strangers)
        if opener.open(packet) is not None:
            raise FaultError(f"a packet was accepted: {kind}", counts, {"packet": packet.hex()})
    if opener.open(sealer.seal(payload)) != payload:
        raise FaultError("a true packet was refused after forged ones", counts)
    return counts


def _forged(
    kind: str, rng: np.random.Generator, true: bytes, payload: bytes, strangers: tuple[channels.Sealer, ...]
) -> bytes:
    other_key, other_session, reflected = strangers
    if kind == "bit":
        at = int(rng.integers(len(true)))
        return true[:at] + bytes([true[at] ^ 1 << int(rng.integers(8))]) + true[at + 1 :]
    if kind == "truncated":
        return true[: int(rng.integers(len(true)))]
    if kind == "extended":
        return true + rng.bytes(int(rng.integers(1, 64)))
    if kind == "other key":
        return other_key.seal(payload)
    if kind == "other session":
        return other_session.seal(payload)
    if kind == "reflected":
        return reflected.seal(payload)
    if kind == "noise":
        return rng.bytes(int(rng.integers(0, 400)))
    if kind == "head":
        return rng.bytes(20) + true[20:]
    return true


def _datagram(rng: np.random.Generator) -> _network.Datagram:
    d, X = _network.Datagram(), np.eye(4)
    X[:3, 3] = rng.normal(size=3) * 0.05
    d.X, d.t, d.F = X, float(rng.uniform(0.0, 1e3)), rng.normal(size=3)
    return d


def _authentic(rng: np.random.Generator) -> dict[str, int]:
    """Damaged content behind the right key: what is decoded moves the goal no faster than the site allows."""
    options = _network.SiteOptions()
    plane = _core.Object("table", _core.Plane(), material=_core.Material(K=np.full(3, 500.0)))
    site, state = _network.Site(options, _core.Snapshot([plane])), _network.SiteInput()
    start = np.eye(4)
    start[:3, 3] = (0.0, 0.0, 0.02)
    state.X, counts = start, {"authentic": 0, "decoded": 0}
    before = start[:3, 3]
    for k in range(_TICKS):
        state.t = 1e-3 * k
        counts["authentic"] += 1
        found = _network.decode(damaged(rng, _network.encode(_datagram(rng)), 2))
        if found is not None:
            counts["decoded"] += 1
            site.receive(found, state.t)
        goal = site.step(state, 1e-3).X[:3, 3]
        if not np.isfinite(goal).all() or np.linalg.norm(goal - before) > 1.01e-3 * options.speed:
            raise FaultError("the goal of the site leaps", counts, {"goal": goal.tolist(), "before": before.tolist()})
        before = goal
    return counts
