"""The example in docs/certificate.md runs unchanged and prints what the page says."""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "certificate.md"


def test_the_example_prints_the_words_on_the_page(capsys):
    found = re.search(r"```python\n((?:.*\n)*?)```\n\n((?: {4}.*\n)+)", PAGE.read_text(encoding="utf-8"))
    script, words = found.groups()
    exec(script, {})
    assert capsys.readouterr().out.split() == words.split()
