"""Measure this machine: start-up, the haptic loop, contact, fixtures, many runs, studies on several cores, ROS 2."""

FIRST = ("loop", "start", "contact", "simulate", "sweep", "guidance", "ros")
