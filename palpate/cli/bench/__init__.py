"""Measure the speed of Palpate: loop, start-up, contact, runs, fixtures, clouds, plans, build, ROS 2."""

FIRST = ("loop", "start", "contact", "simulate", "sweep", "guidance", "cloud", "ros")
