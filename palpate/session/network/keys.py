"""The key that both ends of a link share: made by ``palpate keys``, and copied to the other machine by hand."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from palpate.base import limits
from palpate.base.errors import MissingExtraError, PalpateError

SIZE = 32  # [bytes]
_HEAD = "palpate-remote-key-1 "


def default_path() -> Path:
    """Where the key is without an option: ``~/.config/palpate/remote.key``."""
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config") / "palpate" / "remote.key"


def make_key(path: Path) -> None:
    """Write a new random key that only its owner can read.

    Raises:
        PalpateError: the file exists, or cannot be written.
    """
    if path.exists():
        raise PalpateError(f"{path} exists", mend="give another --out; a key that is in use is not replaced")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(_HEAD + secrets.token_hex(SIZE) + "\n")
    except OSError as error:
        raise PalpateError(f"{path} cannot be written", why=str(error), mend="give another file") from None


def read_key(path: Path) -> bytes:
    """The key of a file.

    Raises:
        PalpateError: there is no such file, others may read it, or it holds no key.
    """
    try:
        text, mode = limits.read_text(path, encoding="latin-1"), path.stat().st_mode
    except FileNotFoundError:
        raise PalpateError(f"{path}: there is no key",
                           mend=f"palpate keys --out {path}, and copy it to both machines") from None  # fmt: skip
    except OSError as error:
        raise PalpateError(
            f"{path}: the key cannot be read", why=str(error), mend="give the file that palpate keys wrote"
        ) from None
    if mode & 0o077:
        raise PalpateError(f"{path}: others may read this key", mend=f"chmod 600 {path}")
    try:
        key = bytes.fromhex(text.removeprefix(_HEAD).strip()) if text.startswith(_HEAD) else b""
    except ValueError:
        key = b""
    if len(key) != SIZE:
        raise PalpateError(f"{path}: this is no key of Palpate", mend="make one with palpate keys")
    return key


def require_cryptography() -> None:
    """Raise MissingExtraError unless the library that encrypts is installed."""
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise MissingExtraError("what encrypts a link", "remote") from None
