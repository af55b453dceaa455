"""A LeRobot data set: rules of the format and of Open-H, numbers by a second way, and the library lerobot itself."""

import json
import os
import subprocess
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from crtk_bag import tool
from crtk_bag import write as write_bag
from lerobot_rules import faults, faults_of_open_h

from palpate.base.errors import RecordError
from palpate.export import export
from palpate.record import Record

pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow (extra learning) is not installed")
LEROBOT = os.environ.get("PALPATE_LEROBOT", "")
"""Interpreter of an environment with lerobot[dataset], which is too heavy for ours."""


def info_of(folder):
    return json.loads((folder / "meta/info.json").read_text())


def column(folder, name):
    files = sorted((folder / "data").rglob("*.parquet"))
    return np.concatenate([np.array(pq.read_table(file)[name].to_pylist()) for file in files])


@pytest.mark.parametrize("names", ["openh", "dvrk"])
@pytest.mark.parametrize("version", ["3.0", "2.1"])
def test_data_set_keeps_the_rules_of_lerobot_and_open_h(make, tmp_path, names, version):
    made = make()
    facts = export([made.path] * 12, tmp_path / "out", names=names, version=version)
    assert faults(tmp_path / "out") == []
    assert (facts["episodes"], facts["frames"]) == (12, 12 * 15)
    assert facts["splits"] == {"train": "0:10", "val": "10:11", "test": "11:12"}
    assert info_of(tmp_path / "out")["robot_type"] == "dvrk"


def test_names_and_sizes_are_those_that_open_h_states(make, tmp_path):
    export(make().path, tmp_path / "one")
    assert faults_of_open_h(tmp_path / "one") == []
    for name in ("left", "right"):
        make(f"run/{name}")
    (tmp_path / "run/scene.yaml").write_text("pairs: {left: {}, right: {}}\n")
    export(tmp_path / "run", tmp_path / "two")
    assert faults_of_open_h(tmp_path / "two", arms=2) == []
    assert "tools ['observation.meta.tool.psm1', 'observation.meta.tool.psm2'] for 1 arms" in faults_of_open_h(
        tmp_path / "two"
    )
    file = tmp_path / "one/meta/info.json"
    info = json.loads(file.read_text())
    force = info["features"]["observation.meta.force_torque"]
    for name, change, words in [
        ("action", {"names": [*"xyz", "qw", "qx", "qy", "qz", "gripper"]}, "action: float32"),
        ("observation.meta.force_torque", {"info": {**force["info"], "sensor": ""}}, "no sensor"),
        ("observation.meta.host_stamp_ns", {"dtype": "float32"}, "host_stamp_ns: float32"),
        ("instruction.text", {"dtype": "int64"}, "no instruction.text"),
    ]:
        changed = {**info["features"], name: info["features"][name] | change}
        file.write_text(json.dumps(info | {"features": changed}))
        assert any(words in one for one in faults_of_open_h(tmp_path / "one")), words


def test_rules_find_what_is_wrong(make, tmp_path):
    """The judge itself: each damage is found."""
    export(make().path, tmp_path / "out")
    file = tmp_path / "out/meta/info.json"
    info = json.loads(file.read_text())
    for change, words in [
        ({"fps": 10}, "fewer than 20"),
        ({"total_frames": 3}, "15 frames, told 3"),
        ({"splits": {"train": "0:2"}}, "splits leave"),
        ({"features": {**info["features"], "naïve": {"dtype": "float32", "shape": [2], "names": None}}}, "not ASCII"),
    ]:
        file.write_text(json.dumps(info | change))
        assert any(words in one for one in faults(tmp_path / "out")), words


def test_frames_hold_state_action_and_forces_by_a_second_way(make, tmp_path):
    made = make(seconds=1.0)
    ticks = made.ticks
    export(made.path, tmp_path / "out")
    at = [round(k * 1000 / 30) for k in range(30)]
    state, action = column(tmp_path / "out", "observation.state"), column(tmp_path / "out", "action")
    np.testing.assert_allclose(state[:, :3], ticks["p_WT"][at], atol=1e-7)
    np.testing.assert_allclose(action[:, :3], ticks["p_WT_goal"][at], atol=1e-7)
    np.testing.assert_allclose(np.abs(state[:, 3:7]), 0.5)
    assert state[0, 6] >= 0.0
    force = column(tmp_path / "out", "observation.meta.force_torque")
    np.testing.assert_allclose(force[:, :3], ticks["F_T_W"][at], atol=1e-6)
    hand = column(tmp_path / "out", "observation.meta.force_torque.mtm")
    np.testing.assert_allclose(hand[:, :3], ticks["F_H_L"][at], atol=1e-6)
    names = info_of(tmp_path / "out")["features"]["observation.meta.force_peak"]["names"]
    peaks = column(tmp_path / "out", "observation.meta.force_peak")
    size = np.linalg.norm(ticks["F_T_W"], axis=1)
    for k in range(1, 30):
        window = slice(at[k - 1] + 1, at[k] + 1)
        for name, values in {"fz": ticks["F_T_W"][window, 2], "f": size[window]}.items():
            for kind, of in (("min", np.min), ("mean", np.mean), ("max", np.max)):
                assert peaks[k, names.index(f"{name}_{kind}")] == pytest.approx(of(values), abs=1e-5)


def test_a_touch_between_two_frames_is_in_the_peak(make, tmp_path):
    made = make(seconds=0.2)
    made.ticks["F_T_W"][50] = [0.0, 3.0, 4.0]
    from palpate.record import Recorder

    with Recorder(tmp_path / "struck.mcap", Record.open(made.path).scene, 0, 1000.0, False) as recorder:
        recorder.append(made.ticks)
    export(tmp_path / "struck.mcap", tmp_path / "out")
    peaks = column(tmp_path / "out", "observation.meta.force_peak")
    assert peaks[:, -1].max() == pytest.approx(5.0)
    assert np.linalg.norm(column(tmp_path / "out", "observation.meta.force_torque")[:, :3], axis=1).max() < 4.0


def test_statistics_are_those_of_all_frames(make, tmp_path):
    export([make("one", 0.5).path, make("two", 1.3).path], tmp_path / "out")
    stats = json.loads((tmp_path / "out/meta/stats.json").read_text())
    for name in ("observation.state", "observation.meta.force_peak", "timestamp", "index"):
        values = column(tmp_path / "out", name).reshape(54, -1)
        for kind, of in (("min", np.min), ("max", np.max), ("mean", np.mean), ("std", np.std)):
            np.testing.assert_allclose(stats[name][kind], of(values, axis=0), rtol=1e-5, atol=1e-7)
        assert stats[name]["count"] == [54]


def test_body_wrench_of_the_dvrk_names_is_turned_into_the_tool(make, tmp_path):
    from scipy.spatial.transform import Rotation

    made = make()
    export(made.path, tmp_path / "out", names="dvrk")
    at = [round(k * 1000 / 30) for k in range(15)]
    w, x, y, z = made.ticks["quat_WT"][0]
    turned = Rotation.from_quat([x, y, z, w]).inv().apply(made.ticks["F_T_W"][at])
    np.testing.assert_allclose(column(tmp_path / "out", "ros.PSM1.body.measured_cf")[:, :3], turned, atol=1e-5)
    assert info_of(tmp_path / "out")["features"]["observation.state"]["names"] == [
        *(f"joint_{k}" for k in range(6)),
        "jaw",
    ]


def test_stamps_are_those_of_the_clock_in_real_time(make, tmp_path):
    started = datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)
    export(make(started=started).path, tmp_path / "out")
    stamps = column(tmp_path / "out", "observation.meta.host_stamp_ns")
    assert stamps[0] == round(started.timestamp() * 1e9)
    assert abs(stamps[3] - stamps[0] - 1e8) < 5e5


def test_runs_with_a_fault_come_last_as_the_split_failure(make, tmp_path):
    good = make("good")
    bad = tmp_path / "bad.mcap"
    from palpate.record import Recorder

    recorder = Recorder(bad, Record.open(good.path).scene, 0, 1000.0, False)
    recorder.append(good.ticks)
    recorder.close(["the device was silent"], None)
    facts = export([bad, good.path], tmp_path / "out")
    assert facts["splits"] == {"train": "0:1", "val": "1:1", "test": "1:1", "failure": "1:2"}
    sources = pq.read_table(tmp_path / "out/meta/episodes/chunk-000/file-000.parquet")["source"].to_pylist()
    assert sources == ["good", "bad"]


def test_records_can_lie_beside(make, tmp_path):
    made = make()
    export(made.path, tmp_path / "out", keep_records=True)
    assert (tmp_path / "out/records/episode_000000.mcap").read_bytes() == made.path.read_bytes()


@pytest.mark.parametrize("names", ["openh", "dvrk"])
def test_pairs_with_leaders_of_one_kind_keep_both(make, tmp_path, names):
    made = [make(f"run/{name}") for name in ("left", "right")]
    made[1].ticks["F_H_L"][:] = [0.0, 0.0, 7.0]
    from palpate.record import Recorder

    with Recorder(made[1].path, Record.open(made[0].path).scene, 0, 1000.0, False) as recorder:
        recorder.append(made[1].ticks)
    (tmp_path / "run/scene.yaml").write_text("pairs: {left: {}, right: {}}\n")
    export(tmp_path / "run", tmp_path / "out", names=names)
    assert faults(tmp_path / "out") == []
    if names == "dvrk":
        assert {"ros.MTMR.spatial.servo_cf", "ros.LEADER2.spatial.servo_cf"} <= info_of(tmp_path / "out")[
            "features"
        ].keys()
        hand = column(tmp_path / "out", "ros.LEADER2.spatial.servo_cf")
    else:
        names = info_of(tmp_path / "out")["features"]["observation.meta.joint_positions.mtm"]["names"]
        assert len(set(names)) == len(names) == 16
        hand = column(tmp_path / "out", "observation.meta.force_torque.mtm")[:, 6:]
    np.testing.assert_allclose(hand[:, 2], 7.0)


def test_an_old_record_lacks_signals_as_nan(tmp_path):
    old = Path(__file__).parents[1] / "record/data/palpate-0.1.0-per-signal.mcap"
    export(old, tmp_path / "out", fps=10)
    assert not [one for one in faults(tmp_path / "out") if "fewer than 20" not in one]
    assert np.isfinite(column(tmp_path / "out", "observation.state")[:, :7]).all()
    asked = column(tmp_path / "out", "action")[:, 3:7]
    assert np.isnan(asked).all() == ("quat_WT_asked" not in Record.open(old).signals)


def test_foreign_bag_of_a_real_arm_exports(tmp_path):
    bag = write_bag(tmp_path / "bag", posed=True)
    export(bag, tmp_path / "out")
    assert faults(tmp_path / "out") == []
    info = info_of(tmp_path / "out")
    assert info["features"]["observation.state"]["info"]["frame"] == "base of the arm"
    assert "observation.meta.force_torque" not in info["features"]
    hand = column(tmp_path / "out", "observation.meta.force_torque.mtm")
    assert np.nanmax(np.abs(hand[:, :3])) == pytest.approx(2.0, abs=0.1)
    at = np.arange(len(hand)) / 30
    np.testing.assert_allclose(column(tmp_path / "out", "observation.state")[:, :3], [tool(t) for t in at], atol=2e-4)
    without = write_bag(tmp_path / "without")
    with pytest.raises(RecordError, match="no measured_cp"):
        export(without, tmp_path / "none")
    export(without, tmp_path / "joints", names="dvrk")
    assert faults(tmp_path / "joints") == []


BASED = """\
arms: {leader: {model: mtm_right}, follower: {model: psm_lnd, base: {xyz: [0.1, 0, 0.2], rpy_deg: [0, 0, 90]}}}
objects: [{name: floor, plane: {size: 0.2}, stiffness: 500}]
"""


@pytest.mark.parametrize("names", ["openh", "dvrk"])
def test_forces_of_a_record_lie_beside_a_foreign_bag(make, tmp_path, names):
    """The clocks put them together: the record began 0.3 s before the bag, and its forces are in the world."""
    bag = write_bag(tmp_path / "bag", posed=True)  # from 100 s since 1970 on, for 2 s
    made = make("node", seconds=1.5, scene=BASED, started=datetime.fromtimestamp(99.7, UTC))
    export(bag, tmp_path / "out", names=names, forces=made.path)
    assert faults(tmp_path / "out") == []
    force = {"openh": "observation.meta.force_torque", "dvrk": "ros.PSM1.body.measured_cf"}[names]
    found = column(tmp_path / "out", force)[:, :3]
    at = np.rint(1000 * (np.arange(len(found)) / 30 + 0.3)).astype(int)
    known = at < len(made.ticks)
    x, y, z = made.ticks["F_T_W"][at[known]].T
    np.testing.assert_allclose(found[known], np.column_stack([y, -x, z]), atol=0.02)  # the base is turned by 90 degrees
    assert np.ptp(z) > 0.5
    assert np.isnan(found[~known][1:]).all()
    assert len(known) - known.sum() > 10
    peaks = column(tmp_path / "out", "observation.meta.force_peak")
    assert np.nanmax(peaks[:, -1]) == pytest.approx(np.linalg.norm(made.ticks["F_T_W"][300:], axis=1).max(), rel=1e-3)
    if names == "openh":
        info = info_of(tmp_path / "out")["features"][force]["info"]
        assert info["frame"] == "base of the arm, about the tool tip"
        assert column(tmp_path / "out", "observation.meta.host_stamp_ns")[0] == 100 * 10**9


def test_forces_that_do_not_belong_to_a_bag_are_refused(make, tmp_path):
    bag = write_bag(tmp_path / "bag", posed=True)
    later = make("later", started=datetime.fromtimestamp(500, UTC)).path
    for runs, forces, words in [
        (bag, later, "did not run during the bag: bag 1970-01-01 00:01:40 to 1970-01-01 00:01:4"),
        (bag, make("lockstep").path, "does not know when it began"),
        (later, later, "forces is for ROS 2 bags"),
    ]:
        with pytest.raises(RecordError, match=words):
            export(runs, tmp_path / "out", forces=forces)
        assert not (tmp_path / "out").exists()


def other(scene, old, new):
    assert old in scene
    return scene.replace(old, new)


def test_runs_that_do_not_fit_are_refused(make, tmp_path):
    scene = Record.open(make("first").path).scene
    first = tmp_path / "first"
    stiffer = make("stiffer", scene=other(scene, "stiffness: 500", "stiffness: 700")).path
    slow = make("slow", rate=500.0).path
    arm = make("arm", scene=other(scene, "psm_lnd", "psm_prograsp")).path
    thin = make("thin", signals=("F_T_W",)).path
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(make("whole", seconds=1.0).path.read_bytes()[:-3000])
    leader = write_bag(tmp_path / "leader", follower=False)
    for paths, words in [
        ([first, stiffer], r"another scene: objects\[0\].stiffness is 700, and 500"),
        ([first, slow], "500 ticks/s, and 1000"),
        ([first, arm], "the arms are mtm_right and psm_prograsp, and mtm_right and psm_lnd"),
        ([thin], "no follower: it lacks p_WT and quat_WT"),
        ([cut], "cut off after"),
        ([leader], "no follower"),
        ([tmp_path / "nothing.mcap"], "nothing.mcap"),
    ]:
        with pytest.raises(RecordError, match=words):
            export(paths, tmp_path / "out")
        assert not (tmp_path / "out").exists()
    with pytest.raises(RecordError, match="40 frames/s are more than the 25 ticks/s"):
        export(make("slower", rate=25.0, seconds=2.0).path, tmp_path / "out", fps=40)
    facts = export([first, stiffer], tmp_path / "out", mixed=True)
    assert facts["episodes"] == 2


def test_command_writes_a_data_set_and_its_facts(make, tmp_path, capsys):
    from json_contract import keys

    from palpate.cli import main

    made = make()
    code = main(["export", str(made.path), "--to", "lerobot", "--out", str(tmp_path / "my set"), "--json", "-"])
    captured = capsys.readouterr()
    assert code == 0
    facts = json.loads(captured.out)
    assert set(facts) <= keys("export records")
    assert "1 episodes, 15 frames" in captured.err
    assert main(["export", str(made.path), "--out", str(tmp_path / "my set")]) == 2
    assert "not empty" in capsys.readouterr().err


_LOAD = """
import sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
for folder in sys.argv[1:]:
    data = LeRobotDataset("local/set", root=folder, delta_timestamps={"action": [0.0, 1 / 30]})
    item = data[20]
    print(len(data), data.num_episodes, tuple(item["action"].shape), item["task"], len(data.meta.stats))
"""


@pytest.mark.skipif(not LEROBOT, reason="PALPATE_LEROBOT names no interpreter with lerobot[dataset]")
def test_lerobot_itself_loads_the_data_set(make, tmp_path):
    made = make()
    export([made.path] * 2, tmp_path / "three")
    export([made.path] * 2, tmp_path / "dvrk", names="dvrk")
    export([made.path] * 2, tmp_path / "two", version="2.1")
    env = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HOME": str(tmp_path / "hf")}
    script = ["-m", "lerobot.scripts.convert_dataset_v21_to_v30", "--repo-id", "local/set", "--push-to-hub", "false"]
    subprocess.run([LEROBOT, *script, "--root", str(tmp_path / "two")], env=env, check=True, capture_output=True)
    folders = [str(tmp_path / name) for name in ("three", "dvrk", "two")]
    told = subprocess.run([LEROBOT, "-c", _LOAD, *folders], env=env, check=True, capture_output=True, text=True).stdout
    assert [line.split()[:4] for line in told.splitlines()] == [["30", "2", "(2,", "8)"], ["30", "2", "(2,", "7)"],
                                                                ["30", "2", "(2,", "8)"]]  # fmt: skip
