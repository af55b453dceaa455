"""Numbers of scene files are refused unless they are finite numbers of the stated sign; text is not a number."""

import math

import pytest
from pydantic import TypeAdapter, ValidationError

from palpate import values

ANY = ["Number", "Positive", "NotNegative"]


def accepted(alias, value):
    try:
        return TypeAdapter(getattr(values, alias)).validate_python(value) == pytest.approx(value)
    except ValidationError:
        return False


@pytest.mark.parametrize("alias", ANY)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, True, None, [1.0], "one"])
def test_what_is_no_finite_number_is_refused(alias, value):
    assert not accepted(alias, value)


@pytest.mark.parametrize("alias", ANY)
def test_signs(alias):
    assert accepted(alias, 0.5)
    assert accepted(alias, 0.0) == (not alias.startswith("Positive"))
    assert accepted(alias, -0.5) == (alias == "Number")


@pytest.mark.parametrize("alias", ["Number", "Positive", "NotNegative"])
def test_text_is_no_number(alias):
    assert not accepted(alias, "0.5")
