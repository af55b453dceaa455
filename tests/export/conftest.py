import dataclasses

import pytest
import synthetic_run

from palpate.record import Recorder

SCENE = """\
arms: {leader: {model: mtm_right}, follower: {model: psm_lnd}}
objects: [{name: floor, plane: {size: 0.2}, stiffness: 500}]
"""


@dataclasses.dataclass
class Made:
    path: object
    ticks: object


@pytest.fixture
def make(tmp_path):
    """Writes records of the synthetic run under a name, with a rate, a length and a scene of choice."""

    def write(name="a run", seconds=0.5, rate=1000.0, scene=SCENE, **more):
        path = tmp_path / name / "record.mcap"
        path.parent.mkdir(parents=True)
        ticks = synthetic_run.run(seconds, rate)
        ticks["quat_WT_asked"] = ticks["quat_WT"]
        with Recorder(path, scene, seed=0, rate=rate, deterministic=False, **more) as recorder:
            recorder.append(ticks)
        return Made(path, ticks)

    return write
