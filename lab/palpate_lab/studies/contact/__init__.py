"""``palpate study contact``: all contact methods on analytic shapes, compared with the exact force F = k (r - phi) n.

The tool follows prescribed paths without hand and arm, so the result depends on the contact method alone.
docs/contact-methods.md explains the figures.
"""
