"""Version and settings of the stand-in of Haply's service, as clients read and write them over HTTP."""

from __future__ import annotations

from typing import Any

from palpate.devices.haply.messages import Config, Json

_SINCE_3_0 = ("gravity_compensation", "handedness", "basis")  # the other settings came with service 3.5


def version(dialect: str) -> Json:
    """What GET /version answers."""
    return {
        "build_time": "2026-01-01T00:00:00Z", "git_branch": "stand-in", "git_describe": f"{dialect}.0",
        "git_hash": "0000000", "git_tag": f"{dialect}.0", "project_name": "haply-inverse-service",
        "project_version": f"{dialect}.0.0",
    }  # fmt: skip


def request_setting(config: Config, dialect: str, method: str, key: str, body: Any) -> tuple[int, Any]:
    """Read, change (POST, PATCH) or reset (DELETE) a setting: status and body of the answer."""
    if setting(config, key) is None or (dialect != "3.5" and key not in _SINCE_3_0):
        return 404, {"ok": False, "error": f"there is no setting {key}"}
    if method in ("POST", "PATCH") and not set_setting(config, key, body):
        return 400, {"ok": False, "error": f"{body!r} is no value of {key}"}
    if method == "DELETE":
        set_setting(config, key, setting(Config(), key))
    return 200, {"ok": True, "data": setting(config, key)}


def set_setting(config: Config, key: str, value: Any) -> bool:
    """Change a setting; False if there is none, or the value is of another kind."""
    now = setting(config, key)
    if now is None or _kind(now) is not _kind(value):
        return False
    if isinstance(now, dict):
        if any(_kind(now[name]) is not _kind(given) for name, given in value.items() if name in now):
            return False
        value = {**now, **value}
    if key == "gravity_compensation":
        config.gravity = value
    elif key == "handedness" and value in ("left", "right"):
        config.handedness = value
    elif key == "basis":
        config.basis = str(value["permutation"])
    elif key == "preset":
        config.preset = str(value["preset"])
    elif key == "filters/damping":
        config.damping = float(value["scalar"])
    elif key == "filters/force_gate":
        config.force_gate = float(value["gain"])
    elif key == "mount":
        config.mount = value
    else:
        return False
    return True


def _kind(value: Any) -> type:
    return float if isinstance(value, int) and not isinstance(value, bool) else type(value)


def setting(config: Config, key: str) -> Any:
    """The value of a setting by its path; None if there is no such setting."""
    return {
        "gravity_compensation": config.gravity,
        "handedness": config.handedness,
        "basis": {"permutation": config.basis},
        "preset": {"preset": config.preset},
        "filters/damping": {"scalar": config.damping},
        "filters/force_gate": {"gain": config.force_gate},
        "mount": config.mount,
    }.get(key)
