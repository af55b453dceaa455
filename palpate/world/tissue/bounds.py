"""Bounds of the values of soft tissues, and the period of their threads."""

HIGHEST_POISSON = 0.495
"""Largest Poisson's ratio that a body accepts: the bulk modulus is then 100 times the shear modulus."""
MOST_TERMS = 4
"""Largest number of Prony terms."""
PERIOD = 4e-3
"""Period of a body that steps on a thread of its own [s]."""
