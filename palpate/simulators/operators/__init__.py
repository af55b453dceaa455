"""Simulated operators: models of a person at the master arm, in closed loop. They are models, not people.

    person = cohort(200, seed=7)[0]                 # traits drawn with published sources (`TRAITS`)
    operator = Operator(person, Senses(force="felt"), seed=1)
    trial = perform(simulation, operator, errand, X_WL, scale, most=20.0)

The results show how arm, haptic cycle and guidance act on an operator with these traits. Only experiments with people
can show whether people have these traits, and how they learn, tire or trust.
"""

from palpate.simulators.operators.cohort import TRAITS, Person, Trait, cohort, person
from palpate.simulators.operators.errand import Aim, Errand
from palpate.simulators.operators.operator import STEP, Operator, Senses
from palpate.simulators.operators.trial import Trial, perform

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
