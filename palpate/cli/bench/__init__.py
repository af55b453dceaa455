"""Measure the speed of Palpate: loop, start-up, contact, runs, fixtures, clouds, tissue, plans, build, ROS 2."""

FIRST = ("loop", "start", "contact", "simulate", "sweep", "guidance", "cloud", "tissue", "ros")
