"""``palpate study zwidth``: which walls a device can render, over stiffness, damping, rate and delay (simulated).

Z-width is the range of impedances that a haptic display renders without swinging (Colgate and Brown 1994). Each point
of the map is a wall (K, B) on a device of one axis with dry friction and whole counts, at a rate and a delay; it is
stable when none of the certificate's presses and taps leaves an oscillation that lasts. Beside the map stands the
stability boundary of the linear sampled loop, and the passive walls of Colgate and Brown.

The device is the simulated MTM at home along the way to the user, unless its numbers are given.
"""
