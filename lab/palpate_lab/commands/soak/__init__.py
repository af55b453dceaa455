"""Run Palpate for very long and count what went wrong: millions of pokes, random hands, days of the node on ROS 2."""

FIRST = ("contact", "device", "ros")
