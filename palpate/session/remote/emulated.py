"""An emulated network between a session and a simulated instrument, in the time of the session's loop."""

from __future__ import annotations

from palpate import _network
from palpate.scene import held
from palpate.session.network.conditions import Network
from palpate.session.remote.site import known, mode, planes, world
from palpate.session.session import Session


def emulate(session: Session, link: Network, seed: int = 0) -> None:
    """Let the hand of a session, which does not run yet, feel the instrument at the far end of a network.

    Both ends are those of ``palpate run --remote``. They need no second process and no real time: in lockstep the same
    seed gives the same record.

    Raises:
        PalpateError: the scene has bodies.
    """
    held.refuse(session.scene, "across a network")
    rig, options = session.rig, _network.EmulatedOptions()
    hand, follower = options.operator_end, options.follower
    site = follower.site
    hand.radius = site.radius = rig.scene.contact.radius
    hand.mode = site.mode = _network.Mode[mode(rig.scene)]
    hand.planes = site.planes = planes(rig.scene)
    follower.site, follower.rate = site, session.rate
    options.operator_end, options.follower = hand, follower
    options.to_site, options.to_operator, options.seed = link.to_site, link.to_operator, seed
    session.linked = True
    session.attach(_network.EmulatedEnd(options, known(rig), world(rig)))
