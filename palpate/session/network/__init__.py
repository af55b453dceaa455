"""Teleoperation across a network: conditions of links, keys, and the channel between both ends.

Packets, clocks, both ends and the emulator are C++ (`palpate._network`, core/palpate/network). docs/network.md.
"""

from palpate.session.network.conditions import NAMES, Network, network

__all__ = ["NAMES", "Network", "network"]
