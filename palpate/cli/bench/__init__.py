"""Measure the speed of Palpate here: loop, start-up, contact, batch runs, fixtures, clouds, tissue, build, ROS 2."""

FIRST = ("loop", "start", "contact", "simulate", "sweep", "guidance", "cloud", "tissue", "ros")
