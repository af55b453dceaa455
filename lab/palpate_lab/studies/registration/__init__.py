"""``palpate study registration``: registrations with known answers, and the errors that they predict.

Fiducials, surfaces and hand-eye views are drawn with stated errors and registered. ``references.py`` contains closed
forms and a second algorithm that share no code with ``palpate.world.registration``.
"""
