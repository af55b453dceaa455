"""Forged and fuzzed messages at each port that strangers can reach: the node, the simulator, OpenIGTLink, the viewer.

One case sends `MESSAGES` messages to one port. Most cases feed the code behind the port directly, which is what makes
a million of them affordable; one in `SOCKETS` goes through a real socket. Messages over ROS 2 itself are those of
`tests/ros/test_sim_fuzz.py`.
"""

from __future__ import annotations

import numpy as np

from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.ports import node, openigtlink, simulator, viewer

MESSAGES = 100
"""Messages of a case."""
SOCKETS = 50
"""One in so many cases of OpenIGTLink and the viewer uses a real socket."""
_PORTS = (
    ("node", node.case, 0.45),
    ("simulator", simulator.case, 0.35),
    ("openigtlink", openigtlink.case, 0.08),
    ("viewer", viewer.case, 0.12),
)


def case(seed: int) -> dict[str, int]:
    """Send the messages of a case.

    Returns:
        Number of messages, which is `MESSAGES`, by port, and of those over a socket.

    Raises:
        FaultError: a message crossed a limit that holds for any message.
    """
    rng = np.random.default_rng([seed, 0x706F7274])
    name, send, _ = _PORTS[rng.choice(len(_PORTS), p=[share for *_, share in _PORTS])]
    by_socket = bool(rng.integers(SOCKETS) == 0) and name in ("openigtlink", "viewer")
    try:
        by_sockets = send(rng, MESSAGES, True) if by_socket else 0
        sent = by_sockets + send(rng, MESSAGES - by_sockets, False)  # a socket carries a few of them
    except FaultError as error:
        raise FaultError(f"{name}: {error}") from None
    except Exception as error:
        raise FaultError(f"{name}: {type(error).__name__}: {error}") from error
    return {"messages": sent, f"{name} messages": sent, **({"by sockets": by_sockets} if by_socket else {})}
