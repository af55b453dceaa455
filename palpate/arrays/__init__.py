"""Arrays: the alias that annotations share."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""An array of floating-point numbers; each use says its shape and unit."""
