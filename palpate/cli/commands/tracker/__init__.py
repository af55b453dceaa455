"""Trackers: serve a simulated one for tests and demonstrations. `palpate tracker` lists the commands."""

FIRST = ("simulate",)
