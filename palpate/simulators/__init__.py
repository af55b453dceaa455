"""Simulated robots that are spoken to like the real ones."""
