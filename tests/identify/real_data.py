"""Folder of the recordings of real arms, which may not be distributed with Palpate."""

import os
from pathlib import Path

import pytest

DATA = Path(os.environ.get("PALPATE_DATA", Path(__file__).parents[3] / "shared/data"))
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"real recordings not found in {DATA} (set PALPATE_DATA)")
