"""Rigid bodies that tools grasp, move and feel: their sections of a scene, and the engine that moves them."""

from palpate.world.bodies.sections import BodySection, EngineSection

__all__ = ["BodySection", "EngineSection"]
