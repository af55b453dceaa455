"""Conditions of networks by name: what they do to the packets of each direction.

The nine conditions of NetFI (Zhang, Roodabeh and Alemzadeh, "A Comprehensive Analysis of the Effects of Network Quality
of Service on Robotic Telesurgery", ICRA 2026, arXiv 2603.06824) have three kinds and three severities. Their delays are
published: a smallest delay of 70, 210 or 406 ms and a mixture of two exponentials (5G). We read the smallest delay as
that of the round trip, half of it each way, and draw the mixture anew in each direction. Of loss and outages only kinds
and ranges are known to us (Gilbert-Elliott and four states; 1 to 8.5 s): these numbers are our own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from palpate import _network
from palpate.base.errors import PalpateError
from palpate.session.network.traces import read_trace

Condition = _network.Condition
MIXTURES = {
    70: ((0.726, 0.274), (27.1, 85.3)),
    210: ((0.893, 0.107), (10.8, 16.2)),
    406: ((0.896, 0.104), (10.2, 15.5)),
}
"""Weights [-] and rates [1/s] of the additional delay, by the smallest round trip [ms]."""


@dataclass(frozen=True)
class Network:
    """Both directions of a link."""

    name: str
    to_site: Condition
    to_operator: Condition
    text: str = ""

    @property
    def round_trip(self) -> float:
        """Smallest round trip [s]."""
        return float(self.to_site.delay + self.to_operator.delay)


def _delayed(round_trip: float) -> Condition:
    condition = Condition()
    condition.delay = 0.5 * round_trip
    return condition


def burst_loss(share: float, burst: float = 10.0) -> _network.GilbertElliott:
    """Loss of this share of packets in bursts of this mean length [packets]."""
    if not 0.0 <= share < 1.0 or burst < 1.0:
        raise PalpateError(
            f"loss {share:g} in bursts of {burst:g}", mend="give a share from 0 to below 1, bursts from 1"
        )
    to_good = 1.0 / burst
    return _network.GilbertElliott(to_bad=min(to_good * share / (1.0 - share), 1.0), to_good=to_good, loss_bad=1.0)


def _lossy(share: float, p14: float) -> Condition:
    condition = _delayed(0.020)
    condition.gilbert = burst_loss(share)
    condition.four = _network.FourStates(p13=0.002, p31=0.2, p32=0.3, p23=0.5, p14=p14)
    return condition


def _netfi_delay(round_trip_ms: int) -> Condition:
    condition = _delayed(1e-3 * round_trip_ms)
    condition.weights, condition.rates = ([*part] for part in MIXTURES[round_trip_ms])
    return condition


def _netfi_outage(seconds: float) -> Condition:
    condition = _delayed(0.020)
    condition.outages = [(4.0, seconds)]
    return condition


def _fibre() -> Condition:
    condition = _delayed(0.010)
    condition.weights, condition.rates, condition.keep_order = [1.0], [1e4], True
    condition.gilbert = _network.GilbertElliott(loss_good=1e-5)
    return condition


def _satellite() -> Condition:
    condition = _delayed(0.480)
    condition.weights, condition.rates, condition.correlation = [1.0], [500.0], 0.9
    condition.keep_order, condition.gilbert = True, burst_loss(0.01, 20.0)
    return condition


NETFI: dict[str, tuple[Callable[[], Condition], str]] = {
    "netfi-loss-1": (lambda: _lossy(0.02, 0.001), "2 % loss in bursts of 10, and single losses"),
    "netfi-loss-2": (lambda: _lossy(0.08, 0.005), "8 %"),
    "netfi-loss-3": (lambda: _lossy(0.20, 0.010), "20 %"),
    "netfi-delay-1": (lambda: _netfi_delay(70), "5G: 70 ms and a mixture of exponentials each way"),
    "netfi-delay-2": (lambda: _netfi_delay(210), "210 ms"),
    "netfi-delay-3": (lambda: _netfi_delay(406), "406 ms"),
    "netfi-outage-1": (lambda: _netfi_outage(1.0), "no packet for 1 s"),
    "netfi-outage-2": (lambda: _netfi_outage(3.0), "for 3 s"),
    "netfi-outage-3": (lambda: _netfi_outage(8.5), "for 8.5 s"),
}
"""The nine conditions of NetFI."""

OTHERS: dict[str, tuple[Callable[[], Condition], str]] = {
    "none": (lambda: _delayed(0.0), "no delay, no loss"),
    "fibre": (_fibre, "10 ms, jitter of 0.1 ms, one packet of 100,000 lost"),
    "satellite": (_satellite, "geostationary: 480 ms, correlated jitter of 2 ms, 1 % loss in bursts of 20"),
}
NAMES = (*OTHERS, *NETFI)
TRACES = (".csv", ".pcap")
"""Ends of the names of measured traces."""


def network(name: str) -> Network:
    """The network with this name, or that of a measured trace (a .csv or .pcap file).

    Raises:
        PalpateError: there is no such condition or file, or the file is no trace.
    """
    known = OTHERS | NETFI
    if name in known:
        make, text = known[name]
        return Network(name, make(), make(), text)
    if name.endswith(TRACES):
        condition = Condition()
        condition.trace = read_trace(name)
        condition.delay = min(delay for _, delay in condition.trace if delay >= 0.0)
        try:
            condition.check()
        except ValueError as error:
            mend = "leave the delay of a lost packet empty"
            raise PalpateError(f"{name}: the trace cannot be played", why=str(error), mend=mend) from None
        return Network(name, condition, condition, "a measured trace")
    mend = "give one of: " + ", ".join(NAMES) + ", or a trace: FILE.csv, FILE.pcap"
    raise PalpateError(f"no network condition is named {name!r}", mend=mend)
