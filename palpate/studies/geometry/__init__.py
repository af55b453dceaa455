"""``palpate study geometry``: sections 3.2 and 3.3 of the paper as numbers and drawings; geometry alone, no arm.

The ideas are in ``palpate.contact.lessons``; docs/geometry.md says what the pictures mean.
"""
