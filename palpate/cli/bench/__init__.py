"""Measure this machine: the haptic loop, contact queries, virtual fixtures, studies on several cores, ROS 2."""

FIRST = ("loop", "contact", "sweep", "guidance", "ros")
