"""YAML of strangers: aliases that unfold, values that contain themselves, depth, and numbers without end."""

import pytest
import yaml

from palpate.base.arrays import yaml_loader


def bomb(levels, width):
    lines = ["a0: &a0 [1, 2]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * width)}]" for k in range(1, levels)]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (bomb(9, 7), "aliases unfold to more than 50,000 values"),
        ("a: &a '" + "x" * 20_000 + "'\nb: [" + "*a, " * 900 + "*a]", "aliases unfold"),
        ("a: &a [*a]", "contains itself"),
        ("a: &a {b: {c: [1, *a]}}", "contains itself"),
        ("[" * 5000, "nested too deeply|while parsing"),
        ("- " * 3000 + "1", "nested too deeply"),
        ("[" + "1, " * 60_000 + "1]", "more than 50,000 values"),
        ("9" * 9000, "digits"),
    ],
)
def test_text_that_unfolds_is_refused(text, words):
    with pytest.raises(yaml.YAMLError, match=words):
        yaml_loader.load(text)


def test_aliases_within_the_limit_are_read():
    read = yaml_loader.load("a: &a [1, 2e-3]\nb: {c: *a, d: *a}")
    assert read == {"a": [1, 0.002], "b": {"c": [1, 0.002], "d": [1, 0.002]}}
    assert len(yaml_loader.load(bomb(4, 7))["a3"]) == 7
    assert yaml_loader.load("") is None
