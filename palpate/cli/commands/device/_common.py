"""Parts that the commands on devices share."""

from __future__ import annotations

import sys

from palpate.base.errors import DeviceError


def require_consent(yes: bool, what: str) -> None:
    """Ask before a motor is commanded.

    Raises:
        DeviceError: the answer is not yes, or there is no terminal to ask in.
    """
    if yes:
        return
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise DeviceError(f"{what}, and there is no terminal to ask in", mend="give --yes if this is safe now")
    print(f"{what}. Let go of the handle, and keep a quarter of the workspace around it free.", file=sys.stderr)
    print("Go on? [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        mend = "answer y; palpate device test --no-push does not push"
        raise DeviceError("not pushed, as you did not say yes", mend=mend)
