"""Does every fixture do what its words say? One suite over every role x geometry x law x policy, none left out.

What is judged is the stage `guidance` of the core, asked through its binding. The judges are numpy's: a distance
formula for every geometry (`specimens`), what each role wants and each law gives restated from their words (`judges`),
and properties that need no formula: finite differences, closed loops, frames, motion, live edits (`checks`). Roles and
laws come from the core's own tables, geometries from its classes: a new one without a judge fails until it has one.
"""

from palpate.verify.conformance import entry
from palpate.verify.conformance.combinations import Combination, combinations
from palpate.verify.conformance.roles import ROLES
from palpate.verify.conformance.run import examine, summary
from palpate.verify.conformance.specimens import SPECIMENS

__all__ = ["ROLES", "SPECIMENS", "Combination", "combinations", "entry", "examine", "summary"]
