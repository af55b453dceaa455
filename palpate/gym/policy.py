"""Policies: functions from an observation to an action, in Python or as ONNX."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError, PalpateError
from palpate.devices.python_file import import_file
from palpate.gym.observation import PARTS, Observation

Policy: TypeAlias = Callable[[Observation], Any]
"""From an observation, arrays (size,) by name, to an action (6,): velocity of the tool's goal in W [m/s, rad/s]."""


class OnnxPolicy:
    """A network in an ONNX file.

    Its inputs are parts of the observation by their name, each (1, size), or one input of any other name: all parts in
    their order, (1, sum of sizes). Its first output is the action, (1, 6). Both are float32.

    Args:
        file: the file.

    Raises:
        PalpateError: the file cannot be read, or has other inputs. MissingExtraError: onnxruntime is not installed.
    """

    def __init__(self, file: str | Path) -> None:
        try:
            import onnxruntime
        except ImportError:
            raise MissingExtraError("onnxruntime", "learning") from None
        try:
            options = onnxruntime.SessionOptions()
            options.intra_op_num_threads = options.inter_op_num_threads = 1  # small networks: threads only cost time
            self._session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime has exceptions of its own, which its documentation does not name
            raise PalpateError("the policy cannot be read", where=str(file), why=str(error).splitlines()[0]) from None
        self.inputs = [one.name for one in self._session.get_inputs()]
        if len(self.inputs) > 1 and not set(self.inputs) <= set(PARTS):
            what = f"the policy has the inputs {', '.join(self.inputs)}"
            mend = f"name them {', '.join(PARTS)}, or give it one input with all parts in this order"
            raise PalpateError(what, where=str(file), mend=mend)

    def __call__(self, seen: Observation) -> Array:
        """The action (6,)."""
        if set(self.inputs) <= set(seen):
            fed = {name: seen[name][None] for name in self.inputs}
        else:
            fed = {self.inputs[0]: np.concatenate([seen[part] for part in PARTS if part in seen])[None]}
        return np.asarray(self._session.run(None, fed)[0], dtype=np.float64).reshape(-1)


def load_policy(name: str) -> Policy:
    """The policy ``FILE.onnx``, ``FILE.py:NAME`` or ``MODULE:NAME``.

    Raises:
        PalpateError: it cannot be found or is no function.
    """
    if name.endswith(".onnx"):
        return OnnxPolicy(name)
    module, _, attribute = name.partition(":")
    try:
        imported = import_file(Path(module), "policy") if module.endswith(".py") else import_module(module)
        found = getattr(imported, attribute)
    except Exception as error:  # whatever the module of a policy raises
        mend = "write FILE.onnx, FILE.py:NAME or MODULE:NAME, of a module that can be imported"
        why = f"{type(error).__name__}: {error}"
        raise PalpateError(f"there is no policy {name!r}", why=why, mend=mend) from error
    if not callable(found):
        raise PalpateError(f"{name!r} is no policy: {type(found).__name__} is not a function", mend="give a function")
    policy: Policy = found
    return policy
