"""Measure the speed: loop, start, records, contact, runs, gym, clouds, tissue, viewer, plans, build, ROS 2."""

FIRST = ("loop", "start", "record", "contact", "simulate", "sweep", "gym", "guidance", "cloud", "tissue", "ros")
