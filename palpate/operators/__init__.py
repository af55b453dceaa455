"""Simulated operators: models of a person at the master arm, in closed loop. They are models, not people.

    person = cohort(200, seed=7)[0]                 # traits drawn with published sources (`TRAITS`)
    operator = Operator(person, Senses(force="felt"), seed=1)
    trial = perform(simulation, operator, errand)   # looks at the rows, leads the hand

What comes out says how a chain of arm, cycle and guidance acts on somebody with these traits. Whether people have them
so, and how they learn, tire or trust, only people can tell.
"""

from palpate.operators.cohort import TRAITS, Person, Trait, cohort, person
from palpate.operators.errand import Aim, Errand
from palpate.operators.operator import STEP, Operator, Senses
from palpate.operators.trial import Trial, perform

__all__ = [
    "STEP",
    "TRAITS",
    "Aim",
    "Errand",
    "Operator",
    "Person",
    "Senses",
    "Trait",
    "Trial",
    "cohort",
    "perform",
    "person",
]
