"""ROS 2 bags of other software: recordings of arms with CRTK topics, read without ROS (library rosbags).

from palpate.record.bags import Bag
bag = Bag.open("rosbag2_2026_11_21-13_00_00")
print(bag.arms, bag.arms["MTMR"].wrench.values)
"""

from palpate.record.bags.bag import Bag
from palpate.record.bags.tracks import ArmTracks, Event, Topic, Track

__all__ = ["ArmTracks", "Bag", "Event", "Topic", "Track"]
