"""DDS security (SROS 2) of this process: security that somebody asked for is on, or nothing starts.

ROS takes security as asked for only if ``ROS_SECURITY_ENABLE`` is exactly ``true``, and runs unprotected, without a
word, where the strategy is not exactly ``Enforce`` and the keys are missing. Here any spelling counts, and missing
keys, unknown values and a middleware without the plug-ins are errors.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from palpate.base.errors import RosMissingError

_YES, _NO = ("true", "1", "yes", "on"), ("", "false", "0", "no", "off")
_FILES = ("identity_ca.cert.pem", "permissions_ca.cert.pem", "cert.pem", "key.pem", "governance.p7s", "permissions.p7s")
_PLUGIN = b"DDS:Auth:PKI-DH"  # name of the plug-in that is compiled into Fast DDS
_INSTALL = (
    "install a ROS 2 whose Fast DDS has them, e.g. ros-jazzy-ros-base on Ubuntu 24.04, and source it; "
    "or unset ROS_SECURITY_ENABLE, and use a separate network"
)


def enforce(libraries: Iterable[Path] = ()) -> bool:
    """Turn security on for the ROS contexts of this process if it is asked for; call it before ROS starts.

    Args:
        libraries: folders with the libraries of ROS.

    Returns:
        True if security is on.

    Raises:
        RosMissingError: security is asked for, and a value is unknown, keys are missing, or the middleware lacks the
            plug-ins.
    """
    asked = os.environ.get("ROS_SECURITY_ENABLE", "").strip()
    if asked.lower() in _NO:
        return False
    if asked.lower() not in _YES:
        raise _refusal(f"ROS_SECURITY_ENABLE={asked} is neither true nor false", mend="write true, or unset it")
    strategy = os.environ.get("ROS_SECURITY_STRATEGY", "").strip()
    if strategy.lower() not in ("", "enforce", "permissive"):
        raise _refusal(f"ROS_SECURITY_STRATEGY={strategy} is unknown", mend="write Enforce")
    _require_keys()
    _require_plugins(libraries)
    os.environ["ROS_SECURITY_ENABLE"], os.environ["ROS_SECURITY_STRATEGY"] = "true", "Enforce"
    return True


def _require_keys() -> None:
    mend = "palpate ros keystore FOLDER ENCLAVE makes keys; it prints the variables"
    store, enclave = os.environ.get("ROS_SECURITY_KEYSTORE", ""), os.environ.get("ROS_SECURITY_ENCLAVE_OVERRIDE", "")
    if not store:
        raise _refusal("there is no keystore: ROS_SECURITY_KEYSTORE is not set", mend=mend)
    if not enclave:
        raise _refusal("no enclave is named: ROS_SECURITY_ENCLAVE_OVERRIDE is not set", where=store, mend=mend)
    place = Path(store) / "enclaves" / enclave.strip("/")
    missing = [name for name in _FILES if not (place / name).is_file()]
    if missing:
        why = f"{', '.join(missing)} missing" if place.is_dir() else "there is no such folder"
        raise _refusal(f"the keystore has no keys for {enclave}", where=str(place), why=why, mend=mend)
    unreadable = [name for name in _FILES if not os.access(place / name, os.R_OK)]
    if unreadable:
        raise _refusal(f"{unreadable[0]} cannot be read", where=str(place), mend="run as the owner of the keys")


def _require_plugins(libraries: Iterable[Path]) -> None:
    """Refuse a Fast DDS without the plug-ins; other middlewares say it themselves when they start."""
    if "fastrtps" not in os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"):
        return
    names = ("libfastdds.so", "libfastrtps.so")  # of Fast DDS 3 and 2
    found = next((folder / name for folder in libraries for name in names if (folder / name).is_file()), None)
    if found is not None and _PLUGIN not in found.read_bytes():
        raise _refusal("this Fast DDS has no security plug-ins", where=str(found), mend=_INSTALL)


def _refusal(what: str, *, where: str = "", why: str = "", mend: str = "") -> RosMissingError:
    text = f"DDS security is asked for, and cannot be on: {what}"
    return RosMissingError(text, where=where, why=why or "nothing starts unprotected in its place", mend=mend)
