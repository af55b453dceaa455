"""The option --pedals of `palpate run`."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack, nullcontext
from typing import TYPE_CHECKING

from palpate.base.errors import PalpateError

if TYPE_CHECKING:
    from palpate.session.console import Console


def pedals(specs: str | None, console: Console, realtime: bool) -> AbstractContextManager[object]:
    """Devices that press the pedals of a console until the context ends.

    Args:
        specs: the devices, separated by blanks (`palpate.session.pedals`); none without any.
        console: the console of the session.
        realtime: the session runs in real time.

    Raises:
        PalpateError: the session runs in lockstep. DeviceError: a device cannot be read.
    """
    if not specs:
        return nullcontext()
    if not realtime:
        raise PalpateError("--pedals has no effect in lockstep, whose time is its own", mend="add --realtime")
    from palpate.session.pedals import PedalDevice

    devices = ExitStack()
    try:
        for spec in specs.split():
            devices.enter_context(PedalDevice(console, spec))
    except BaseException:
        devices.close()
        raise
    return devices
