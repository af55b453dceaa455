"""The hand of a headset: takes its poses from the viewer's page and sends back how strongly it shall vibrate."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from websockets.exceptions import ConnectionClosed

from palpate.devices.webxr import FEEDS

PATH = "/xr"
"""Path of the web socket."""
MOST_MESSAGE = 2048
"""Largest message of the page [bytes]."""
_PERIOD, _IDLE = 1.0 / 30.0, 0.5  # between two looks at what the page shall know, and without a hand [s]


async def serve(connection: Any) -> None:
    """Exchange messages with a page until it leaves; its hands then count as not tracked."""
    telling = asyncio.create_task(_tell(connection))
    try:
        async for text in connection:
            take(text)
    except ConnectionClosed:
        return
    finally:
        telling.cancel()
        for feed in list(FEEDS.values()):
            feed.lose()


def take(text: str | bytes) -> bool:
    """Take a message {hand, p, q, pinch, buttons, tracked}; False if it is not valid or nobody asks for that hand."""
    if len(text) > MOST_MESSAGE:
        return False
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return False
    hand = message.get("hand") if isinstance(message, dict) else None
    feed = FEEDS.get(hand) if isinstance(hand, str) else None
    if feed is None:
        return False
    if message.get("tracked") is not True:
        feed.lose()
        return True
    return feed.take(message)


async def _tell(connection: Any) -> None:
    """Tell the page which hands are asked for, and how strongly they vibrate, whenever that changes."""
    before = ""
    while True:
        now = json.dumps({"vibration": {hand: round(feed.vibration, 3) for hand, feed in sorted(FEEDS.items())}})
        if now != before or any(feed.vibration > 0.0 for feed in FEEDS.values()):
            await connection.send(now)
            before = now
        await asyncio.sleep(_PERIOD if FEEDS else _IDLE)
