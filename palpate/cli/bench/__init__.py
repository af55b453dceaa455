"""Measure the speed of Palpate: loop, start, records, contact, runs, clouds, tissue, viewer, plans, build, ROS 2."""

FIRST = ("loop", "start", "record", "contact", "simulate", "sweep", "guidance", "cloud", "tissue", "ros")
