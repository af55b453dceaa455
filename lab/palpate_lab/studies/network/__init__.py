"""``palpate study network``: a simulated hand feels a remote surface through emulated networks.

Both ends, the link and the instrument are those of `core/palpate/network`, in virtual time. The judge integrates the
energies of hand and instrument over their simulated motion, and compares the felt force with that of the true surface
at the hand's position when its motion is executed. docs/network-figures.md explains the figures.
"""
