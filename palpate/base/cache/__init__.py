"""Disk cache of generated shapes and mesh indices, in the user's cache folder."""

from palpate.base.cache.store import (
    LIMIT_BYTES,
    Arrays,
    Entry,
    clear,
    entries,
    folder,
    keep,
    keep_bytes,
    load,
    load_bytes,
    load_or_make,
    source_key,
)

__all__ = [
    "LIMIT_BYTES",
    "Arrays",
    "Entry",
    "clear",
    "entries",
    "folder",
    "keep",
    "keep_bytes",
    "load",
    "load_bytes",
    "load_or_make",
    "source_key",
]
