"""Benchmarks: a command, a number, a machine."""
