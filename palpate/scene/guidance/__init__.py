"""Virtual fixtures: constraints on the tool, each made from a geometry, a role and a law (docs/guidance.md)."""

from palpate.scene.guidance.combine import Difference, Geometry, Intersection, Offset, Union
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.geometry import (
    Box,
    Cloud,
    Cone,
    Cylinder,
    Grid,
    Line,
    Mesh,
    OfObject,
    Plane,
    Point,
    Shape,
    Sphere,
)
from palpate.scene.guidance.lists import from_yaml, to_yaml
from palpate.scene.guidance.paths import Path, Tube
from palpate.scene.guidance.sections import Law, Ramp, Role

__all__ = [
    "Box",
    "Cloud",
    "Cone",
    "Cylinder",
    "Difference",
    "Fixture",
    "FixtureContext",
    "Geometry",
    "Grid",
    "Intersection",
    "Law",
    "Line",
    "Mesh",
    "OfObject",
    "Offset",
    "Path",
    "Plane",
    "Point",
    "Ramp",
    "Role",
    "Shape",
    "Sphere",
    "Tube",
    "Union",
    "from_yaml",
    "to_yaml",
]
