"""Results become values that a JSON file can hold."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from palpate.base.arrays.plain import plain


@dataclass(frozen=True)
class Inner:
    name: str
    at: tuple[float, float]


@dataclass(frozen=True)
class Outer:
    z_N: np.ndarray
    a_m: float
    inner: Inner | None
    by_name: dict[str, Inner]


def test_a_dataclass_becomes_its_fields_in_their_order():
    inner = Inner("tip", (1.0, 2.0))
    values = plain(Outer(np.eye(2), np.float64(0.5), None, {"x": inner}))
    assert list(values) == ["z_N", "a_m", "inner", "by_name"]
    expected = {"z_N": [[1.0, 0.0], [0.0, 1.0]], "a_m": 0.5, "inner": None}
    assert values == expected | {"by_name": {"x": {"name": "tip", "at": [1.0, 2.0]}}}
    assert type(values["a_m"]) is float
    assert json.loads(json.dumps(values)) == values


def test_what_is_not_plain_is_refused_by_its_type():
    with pytest.raises(TypeError, match="a set is not a plain value"):
        plain({"a": {1, 2}})
    with pytest.raises(TypeError, match="a type is not a plain value"):
        plain(Inner)
