"""References for soft tissue that share no code with the product: a fine axisymmetric finite element model."""

