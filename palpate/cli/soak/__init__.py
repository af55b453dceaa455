"""Run Palpate for very long and count what went wrong: millions of pokes, or days of the haptic node on ROS 2."""

FIRST = ("contact", "ros")
