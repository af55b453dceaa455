"""References for soft tissue that share no code with the product: a fine axisymmetric finite element model."""

from palpate_lab.verify.tissue.reference import PATH, reference_force

__all__ = ["PATH", "reference_force"]
