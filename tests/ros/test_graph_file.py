"""Beside a record lies who published and who listened, a line for each change."""

import json
from types import SimpleNamespace

from palpate.ros.around.graph_file import NAME, GraphFile


class Node:
    """A stand-in for a node of rclpy with a graph."""

    def __init__(self):
        self.ends = {
            "/MTMR/measured_cp": (["dvrk"], ["palpate"]),
            "/rosout": (["dvrk"], []),
            "/quiet": ([], ["palpate"]),
        }

    def get_topic_names_and_types(self):
        return [(name, ["geometry_msgs/msg/PoseStamped"]) for name in self.ends]

    def get_publishers_info_by_topic(self, name):
        return [SimpleNamespace(node_name=one, node_namespace="/") for one in self.ends[name][0]]

    def get_subscriptions_info_by_topic(self, name):
        return [SimpleNamespace(node_name=one, node_namespace="/room") for one in self.ends[name][1]]


def lines(folder):
    return [json.loads(line)["topics"] for line in (folder / NAME).read_text().splitlines()]


def test_each_change_is_one_line(tmp_path):
    node, session = Node(), SimpleNamespace(record=None)
    file = GraphFile(node, session)
    file.look()
    assert not list(tmp_path.iterdir()), "nothing is recorded"
    session.record = tmp_path / "record.mcap"
    file.look()
    file.look()
    first = {"type": "geometry_msgs/msg/PoseStamped", "publishers": ["/dvrk"], "subscribers": ["/room/palpate"]}
    assert lines(tmp_path) == [{"/MTMR/measured_cp": first}]
    node.ends["/MTMR/measured_cp"][0].append("forgotten_sim")
    file.look()
    assert lines(tmp_path)[1]["/MTMR/measured_cp"]["publishers"] == ["/dvrk", "/forgotten_sim"]
    other = tmp_path / "second"
    other.mkdir()
    session.record = other / "record.mcap"
    file.look()
    assert len(lines(other)) == 1


def test_a_folder_that_is_gone_ends_nothing(tmp_path):
    file = GraphFile(Node(), SimpleNamespace(record=tmp_path / "gone" / "record.mcap"))
    file.look()
