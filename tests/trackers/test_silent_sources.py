"""A source that never spoke is told: in the faults of the summary, which terminal, JSON, record and report show."""

import json

import numpy as np
import pytest

from palpate import Scene, Session
from palpate.record.reader import Record

FRAMES = (
    "frames: [{{child: marker, tracker: plus, tool: MarkerToTracker, pose: {{xyz: [0.1, 0.0, 1.0]}}}}]\n"
    "trackers: {{plus: {source}}}\n"
    "objects: [{{name: ball, sphere: {{radius: 0.03}}, frame: marker}}]\n"
)


class Source:
    """A tracker that sees the marker from `begin` to `end` [s]."""

    def __init__(self, begin, end):
        self.begin, self.end = begin, end

    def poll(self, now):
        from palpate.sensing.trackers import Sighting

        X = np.eye(4)
        X[:3, 3] = [0.1, 0.0, 1.0]
        return [Sighting("MarkerToTracker", X, now)] if self.begin <= now <= self.end else []

    def heard(self, tool):
        return "StylusToTracker arrives"

    def close(self):
        pass


def session(begin, end, tmp_path):
    pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
    made = Session(Scene.parse(FRAMES.format(source="{openigtlink: 127.0.0.1:9}")), out=tmp_path)
    made.tracking._trackers["plus"].close()
    made.tracking._trackers["plus"] = Source(begin, end)
    return made


@pytest.mark.usefixtures("without_figures")
@pytest.mark.parametrize(
    ("begin", "end", "words"),
    [
        (np.inf, np.inf, "not seen yet: StylusToTracker arrives; no force from ball"),
        (0.0, 0.1, "no pose arrives; StylusToTracker arrives; no force from ball"),
        (0.0, np.inf, None),
    ],
)
def test_a_tool_that_is_not_seen_is_told_in_summary_and_record(begin, end, words, tmp_path):
    made = session(begin, end, tmp_path)
    summary = made.run(1.6, realtime=True)
    told = [
        fault for fault in summary.faults if fault.startswith("tracked frame marker (tool MarkerToTracker of plus)")
    ]
    assert len(told) == (words is not None)
    record = Record.open(summary.record)
    assert [fault for fault in record.faults if fault.startswith("tracked frame")] == told
    if words:
        assert told[0].endswith(words)
        from palpate.report import write_report

        assert words.split(";")[0] in write_report(record.path).read_text()


@pytest.mark.usefixtures("without_figures")
def test_the_command_tells_it(tmp_path, capsys):
    pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
    from palpate.cli import main

    (tmp_path / "a.yaml").write_text(FRAMES.format(source="{openigtlink: 127.0.0.1:9}"))
    command = ["run", f"{tmp_path}/a.yaml", "--realtime", "--headless", "--duration", "1"]
    main([*command, "--out", f"{tmp_path}/runs", "--json", f"{tmp_path}/a.json"])
    faults = json.loads((tmp_path / "a.json").read_text())["faults"]
    assert any("no connection to 127.0.0.1:9" in fault and "no force from ball" in fault for fault in faults)
    assert "no connection to 127.0.0.1:9" in " ".join(capsys.readouterr().out.split())


def test_a_camera_that_never_gives_a_surface_is_told():
    scene = Scene.parse("objects: [{name: organ, cloud: {sensor: camera}, stiffness: 300}]\n")

    class Empty:
        def latest(self, now):
            from palpate.sensing.source import CloudFrame

            return CloudFrame(np.full((100, 3), np.nan), now)

        def heard(self):
            return "no node publishes /camera"

        def close(self):
            pass

    for source, words in ((Empty(), "frames without a valid point"), ([], "no frame came")):
        made = Session(scene, clouds={"camera": source})
        made.step(1000)
        (told,) = made.sensing.silent(1.0)
        assert told.startswith("cloud organ: no surface was made: ")
        assert words in told
        assert made.sensing.silent(0.1) == []
