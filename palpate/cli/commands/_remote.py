"""`palpate run --remote`: the operator's end of a link beside a session."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from palpate.base.errors import PalpateError, SceneError

if TYPE_CHECKING:
    from palpate.scene import Scene
    from palpate.session import PairsSession, Session
    from palpate.session.remote.link import RemoteLink


def require(scene: Scene, at: str | None, fast: bool) -> None:
    """Refuse what cannot run across a network, and wrong addresses.

    Raises:
        PalpateError: the message names the part.
    """
    from palpate.session.network import network
    from palpate.session.network.channel import address
    from palpate.session.network.keys import require_cryptography
    from palpate.session.remote.together import network_name

    require_cryptography()
    if at is not None:
        address(at)
    if fast:
        raise PalpateError("--fast has no effect across a network, which runs in real time", mend="leave it out")
    for part, given in (
        ("trackers", scene.trackers),
        ("sensors", scene.sensors),
        ("bodies", scene.bodies),
    ):
        if given:
            raise SceneError(f"a scene with {part} does not run across a network", where=scene.where(part),
                             mend="leave the section out")  # fmt: skip
    section = scene.remote
    if section is not None:
        network(network_name(scene))


@contextmanager
def joined(session: Session | PairsSession, at: str | None, key: Path | None) -> Iterator[RemoteLink | None]:
    """The link of a session: to the address, to processes on this machine as the scene says, or none.

    Raises:
        PalpateError: there is no follower, or it refuses.
    """
    section = session.scene.remote
    if at is None and (section is None or not section.together):
        yield None
        return
    from palpate.session.network.channel import address
    from palpate.session.network.keys import default_path, read_key
    from palpate.session.remote.link import RemoteLink
    from palpate.session.remote.together import Together, network_name

    rate = 1000.0 if section is None else section.rate
    if at is not None:
        link = RemoteLink(session, address(at), read_key(key or default_path()), rate)
        with link:
            yield link
        return
    with (
        Together(session.scene, network_name(session.scene)) as both,
        RemoteLink(session, both.at, both.key, rate) as link,
    ):
        yield link
