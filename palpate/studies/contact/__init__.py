"""``palpate study contact``: every method over every shape that is known exactly, judged against F = k (r - phi) n.

Prescribed tool paths, no hand and no arm: what is measured is the contact method alone. What the
figures mean is in docs/contact-methods.md.
"""
