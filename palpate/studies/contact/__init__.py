"""``palpate study contact``: every method over every shape that is known exactly, judged against F = k (r - phi) n.

Prescribed tool paths, no hand and no arm: what is measured is the contact method alone. Figures in
``contact_figures``; what they mean is in docs/contact.md.
"""
