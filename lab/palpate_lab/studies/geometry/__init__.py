"""``palpate study geometry``: sections 3.2 and 3.3 of the paper as numbers and drawings, without an arm.

The geometry is computed by ``palpate.scene.contact.lessons``; docs/geometry.md explains the pictures.
"""
