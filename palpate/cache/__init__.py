"""Shapes and mesh indices that took long to make, kept between runs in the user's cache folder."""

from palpate.cache.store import LIMIT_BYTES, Arrays, Entry, clear, entries, folder, kept, source_key

__all__ = ["LIMIT_BYTES", "Arrays", "Entry", "clear", "entries", "folder", "kept", "source_key"]
