"""Benchmarks of contact, fixtures, the haptic loop, ROS 2, batch runs, start-up and sweeps."""
