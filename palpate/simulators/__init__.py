"""Simulated robots with the interfaces of the real ones."""
