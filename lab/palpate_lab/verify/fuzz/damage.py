"""Damages valid files: cut, overwritten, repeated and exchanged parts, and critical words."""

from __future__ import annotations

import re

import numpy as np

WORDS = (
    *(b"nan", b"-inf", b"1e309", b"-1", b"0", b"1e-300", b"99999999999", b"null", b"true", b"''", b"[]", b"{}"),
    *(b"\0", b"\xff\xff\xff\xff", b"\n", b",", b":", b"- ", b"&a *a", b"<", b'"', b"\xc3\xa9", b"=1+1"),
)
"""Words that readers of numbers, YAML, JSON and XML are likely to stumble over."""
_TOKEN = re.compile(rb"[-+.\w]+")


def damaged(rng: np.random.Generator, data: bytes, most: int = 4) -> bytes:
    """`data` with up to `most` faults; half of these exchange one word, so that the rest stays valid."""
    for _ in range(int(rng.integers(0, most + 1))):
        at = int(rng.integers(0, len(data) + 1))
        kind = int(rng.integers(0, 8))
        word = WORDS[rng.integers(len(WORDS))]
        tokens = list(_TOKEN.finditer(data)) if kind > 3 else []
        if kind == 0:
            data = data[:at]
        elif kind == 1:
            data = data[:at] + rng.bytes(int(rng.integers(1, 9))) + data[at + int(rng.integers(0, 9)) :]
        elif kind == 2:
            data = data[:at] + word + data[at + int(rng.integers(0, len(word) + 1)) :]
        elif kind == 3:
            start = int(rng.integers(0, len(data) + 1))
            data = data[:at] + data[start : start + int(rng.integers(0, 300))] + data[at:]
        elif tokens:
            token = tokens[rng.integers(len(tokens))]
            other = tokens[rng.integers(len(tokens))].group()
            new = word if kind < 6 else other if kind == 6 else _number(rng)
            data = data[: token.start()] + new + data[token.end() :]
    return data


def _number(rng: np.random.Generator) -> bytes:
    """A number of any size and either sign."""
    return f"{rng.choice([-1, 1]) * 10.0 ** rng.uniform(-12, 12):.6g}".encode()
