"""Conformance suite of the guidance stage: every combination of role, geometry, law and policy is checked.

The suite runs the core's stage `guidance` through its binding. The references are written in numpy: a distance function
of every geometry (`specimens`), and every role's constraint and every law's force from the documentation (`roles`,
`laws`). Further checks need no reference: finite differences, closed loops, frames, motion and live edits. Roles and
laws are listed by the core, geometries by its classes; a new entry without a reference fails the suite.
"""

from palpate_lab.verify.conformance import entry
from palpate_lab.verify.conformance.combinations import Combination, combinations, sample
from palpate_lab.verify.conformance.probes import drawn
from palpate_lab.verify.conformance.roles import ROLES
from palpate_lab.verify.conformance.run import examine, summary
from palpate_lab.verify.conformance.specimens import SPECIMENS

__all__ = ["ROLES", "SPECIMENS", "Combination", "combinations", "drawn", "entry", "examine", "sample", "summary"]
