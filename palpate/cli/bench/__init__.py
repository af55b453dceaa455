"""Measure the speed of Palpate: loop, start, contact, runs, fixtures, clouds, tissue, viewer, plans, build, ROS 2."""

FIRST = ("loop", "start", "contact", "simulate", "sweep", "guidance", "cloud", "tissue", "ros")
