"""Virtual fixtures: constraints on the tool, each made from a geometry, a role and a law (docs/guidance.md)."""

from palpate.guidance.combine import Difference, Geometry, Intersection, Offset, Union
from palpate.guidance.fixture import Fixture
from palpate.guidance.geometry import (
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
from palpate.guidance.here import Here
from palpate.guidance.lists import from_yaml, to_yaml
from palpate.guidance.paths import Path, Tube
from palpate.guidance.sections import Law, Ramp, Role

__all__ = [
    "Box",
    "Cloud",
    "Cone",
    "Cylinder",
    "Difference",
    "Fixture",
    "Geometry",
    "Grid",
    "Here",
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
