"""The safe YAML loader of all files that people write, and the fastest safe loader and dumper for our own texts."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import yaml
from yaml.composer import Composer

if TYPE_CHECKING or not yaml.__with_libyaml__:
    _SafeLoader = yaml.SafeLoader
else:

    class _SafeLoader(Composer, yaml.CSafeLoader):
        """Parses text in C, ten times faster, and composes nodes in Python, whose recursion ends with an exception."""

        def __init__(self, stream: str) -> None:
            yaml.CSafeLoader.__init__(self, stream)
            Composer.__init__(self)


OwnLoader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Loader of texts that Palpate wrote itself, in C where PyYAML has it, ten times faster."""
Dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""Dumper of `yaml.safe_dump`, in C where PyYAML has it, ten times faster."""


class Loader(_SafeLoader):
    """Safe YAML loader that reads 1e-3 as a number (YAML 1.1 requires 1.0e-3) and does not parse dates."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:timestamp"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)
