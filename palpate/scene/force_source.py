"""The source of the force, as the core takes it: made from the section `force` and the follower's dynamics."""

from __future__ import annotations

import warnings
from pathlib import Path

import yaml

from palpate import _core
from palpate.arm import Arm
from palpate.errors import PalpateWarning, RecordingError, SceneError
from palpate.scene.scene import Scene


def fill(options: _core.SimulationOptions, scene: Scene, arm: Arm) -> None:
    """Source, drives and estimate of the follower `arm`.

    Raises:
        SceneError: the model of its dynamics cannot be read, or is of another arm.
    """
    section, estimate = scene.force, _core.EstimateOptions()
    options.source = section.source
    options.follower.driven = section.source != "contact"  # only drives with torques have something to tell
    estimate.bandwidth, estimate.dead_band = section.bandwidth, section.dead_band
    path = scene.dynamics_path()
    if path is None:
        drives = options.follower.drives
        estimate.coulomb, estimate.viscous, estimate.rotor_inertia = (
            drives.coulomb,
            drives.viscous,
            drives.rotor_inertia,
        )
    else:
        estimate = _identified(estimate, path, scene, arm)
    options.estimate = estimate


def _identified(options: _core.EstimateOptions, path: Path, scene: Scene, arm: Arm) -> _core.EstimateOptions:
    from palpate.arm.dynamics import from_data
    from palpate.arm.observer import estimate_options

    where = scene.where("force", "dynamics")
    try:
        return estimate_options(from_data(yaml.safe_load(path.read_text(encoding="utf-8")), arm, str(path)), options)
    except OSError as error:
        told, mend = f"{path}: {error.strerror or error}", "palpate calibrate dynamics writes one"
        raise SceneError("the dynamics cannot be read", where=where, why=told, mend=mend) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SceneError("the dynamics are no YAML", where=where, why=str(error), mend="identify them again") from None
    except RecordingError as error:
        raise SceneError(error.what, where=where, why=error.why or str(path), mend=error.mend) from None


def check_presence(scene: Scene) -> None:
    """Objects that nothing tells of are refused; those that are told of twice are warned of.

    Raises:
        SceneError: names the object.
    """
    for i, thing in enumerate(scene.objects):
        where, source = scene.where("objects", i, "presence"), scene.force.source
        if thing.presence == {"contact": "real", "estimate": "virtual"}.get(source):
            raise SceneError(
                f"object {thing.name!r} is {thing.presence} alone and force.source is {source!r}: nobody feels it",
                where=where, mend="force: {source: both}, or another presence",
            )  # fmt: skip
        if source == "both" and thing.presence == "both":
            what = f"object {thing.name!r} is felt twice: as a virtual surface, and through the follower's drives"
            warnings.warn(PalpateWarning(what, where=where, mend="presence: real, or virtual"), stacklevel=3)
