"""Simulated counterparts: robots with the interfaces of the real ones, and operators."""
