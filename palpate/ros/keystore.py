"""Creates a keystore for DDS security (SROS 2) with openssl, in the layout of `ros2 security create_keystore`.

    keystore-authority/ca.cert.pem  ca.key.pem              the authority: signs identities and permissions
    keystore/public/ca.cert.pem
    keystore/enclaves/governance.p7s                        encryption rules: everything is encrypted
    keystore/enclaves/NAME/{cert,key}.pem permissions.p7s   one folder for each enclave, with copies of the above

The key of the authority lies beside the keystore, not in it: who has it can make any key. `palpate.ros.roles` says what
each enclave may publish and hear, on any domain (0 to 230, a range that every DDS can read). A participant without a
certificate of this authority cannot join, discovers no topic, and is ignored.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from palpate.base.errors import OutputError, PalpateError
from palpate.ros.roles import Role, role_of, topics

DAYS = 3650
"""Validity of the certificates [days]."""
_GOVERNANCE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules><domain_rule>
    <domains><id_range><min>0</min><max>230</max></id_range></domains>
    <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
    <enable_join_access_control>true</enable_join_access_control>
    <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
    <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
    <rtps_protection_kind>SIGN</rtps_protection_kind>
    <topic_access_rules><topic_rule>
      <topic_expression>*</topic_expression>
      <enable_discovery_protection>true</enable_discovery_protection>
      <enable_liveliness_protection>true</enable_liveliness_protection>
      <enable_read_access_control>true</enable_read_access_control>
      <enable_write_access_control>true</enable_write_access_control>
      <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
      <data_protection_kind>ENCRYPT</data_protection_kind>
    </topic_rule></topic_access_rules>
  </domain_rule></domain_access_rules>
</dds>
"""
_PERMISSIONS = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions><grant name="{name}">
    <subject_name>CN={name}</subject_name>
    <validity><not_before>2020-01-01T00:00:00</not_before><not_after>2099-01-01T00:00:00</not_after></validity>
    <allow_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <publish><topics>{said}</topics></publish>
      <subscribe><topics>{heard}</topics></subscribe>
    </allow_rule>
    <default>DENY</default>
  </grant></permissions>
</dds>
"""


def make(folder: Path, enclaves: tuple[str, ...], authority: Path | None = None) -> list[Path]:
    """Create a keystore, or add enclaves to one; existing keys stay, and permissions become those of the roles.

    Args:
        folder: folder of the keystore, which the machines of the enclaves get.
        enclaves: names such as ``/palpate/haptics``, whose last part is the role, or ``/lab/left=camera``.
        authority: folder of the authority's key; FOLDER-authority when left out.

    Returns:
        The folders of the enclaves.

    Raises:
        PalpateError: openssl is not installed, an enclave name is invalid, or its role is unknown.
        OutputError: the folder cannot be written.
    """
    if shutil.which("openssl") is None:
        raise PalpateError("openssl is not installed", mend="sudo apt install openssl")
    named = [role_of(enclave) for enclave in enclaves]
    authority = authority or folder.with_name(f"{folder.resolve().name}-authority")
    if authority.resolve().is_relative_to(folder.resolve()):
        raise PalpateError(
            "the authority's key must not lie in the keystore", where=str(authority), mend="name another folder"
        )
    try:
        for place in (folder / "public", folder / "enclaves", authority):
            place.mkdir(parents=True, exist_ok=True)
        authority.chmod(0o700)
        signer = _authority(folder, authority)
        return [_enclave(folder, signer, name, role) for name, role in named]
    except OSError as error:
        raise OutputError("the keystore cannot be written", where=str(folder), why=str(error)) from None


def environment(folder: Path, enclave: str) -> dict[str, str]:
    """Environment variables for a process of this enclave; with them, it does not start without security."""
    return {
        "ROS_SECURITY_KEYSTORE": str(folder.resolve()),
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_ENCLAVE_OVERRIDE": enclave,
    }


class _Signer(NamedTuple):
    cert: Path
    key: Path


def _authority(folder: Path, authority: Path) -> _Signer:
    signer, public = _Signer(authority / "ca.cert.pem", authority / "ca.key.pem"), folder / "public" / "ca.cert.pem"
    kept = folder / "private" / "ca.key.pem"  # where keystores had it before, and where `ros2 security` has it
    if kept.exists() and not signer.key.exists():
        shutil.copy(public, signer.cert)
        shutil.move(kept, signer.key)
        with suppress(OSError):
            kept.parent.rmdir()
    if not signer.cert.exists():
        if public.exists():
            what = "the authority of this keystore has no key here"
            raise PalpateError(what, where=str(authority), mend="name its folder: --authority DIR")
        _key(signer.key)
        _openssl("req", "-x509", "-new", "-key", signer.key, "-sha256", "-days", DAYS, "-subj", "/CN=palpateCA",
                 "-out", signer.cert)  # fmt: skip
    shutil.copy(signer.cert, public)
    governance = folder / "enclaves" / "governance.xml"
    if not governance.exists():
        governance.write_text(_GOVERNANCE)
    if not governance.with_suffix(".p7s").exists():
        _sign(signer, governance)
    return signer


def _enclave(folder: Path, signer: _Signer, name: str, role: Role) -> Path:
    place = folder / "enclaves" / name.strip("/")
    place.mkdir(parents=True, exist_ok=True)
    cert, key, request = place / "cert.pem", place / "key.pem", place / "request.pem"
    if not cert.exists():
        _key(key)
        subject = f"/CN={name.replace('/', chr(92) + '/')}"  # a slash separates the fields of a subject
        _openssl("req", "-new", "-key", key, "-sha256", "-subj", subject, "-out", request)
        _openssl("x509", "-req", "-in", request, "-CA", signer.cert, "-CAkey", signer.key, "-set_serial",
                 str(_serial()), "-days", DAYS, "-sha256", "-out", cert)  # fmt: skip
        request.unlink()
    permissions = place / "permissions.xml"
    said, heard = ("".join(f"<topic>{topic}</topic>" for topic in names) for names in topics(role))
    permissions.write_text(_PERMISSIONS.format(name=name, said=said, heard=heard))
    _sign(signer, permissions)
    for copy in ("identity_ca.cert.pem", "permissions_ca.cert.pem"):
        shutil.copy(signer.cert, place / copy)
    shutil.copy(folder / "enclaves" / "governance.p7s", place)
    return place


def _serial() -> int:
    return int.from_bytes(os.urandom(8), "big")


def _key(path: Path) -> None:
    _openssl("ecparam", "-name", "prime256v1", "-genkey", "-noout", "-out", path)
    path.chmod(0o600)


def _sign(signer: _Signer, document: Path) -> None:
    _openssl("smime", "-sign", "-text", "-in", document, "-signer", signer.cert, "-inkey", signer.key,
             "-out", document.with_suffix(".p7s"))  # fmt: skip


def _openssl(*arguments: object) -> None:
    done = subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise PalpateError(f"openssl {arguments[0]} fails", why=done.stderr.strip().splitlines()[-1])
