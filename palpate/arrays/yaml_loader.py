"""The safe YAML loader of all files that people write."""

from __future__ import annotations

import re

import yaml


class Loader(yaml.SafeLoader):
    """Safe YAML loader that reads 1e-3 as a number (YAML 1.1 requires 1.0e-3) and does not parse dates."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:timestamp"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)
