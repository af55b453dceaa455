"""``palpate study zwidth``: which walls a device can render, over stiffness, damping, rate and delay (simulated).

Z-width is the range of impedances that a haptic display renders without oscillation (Colgate and Brown 1994). Each
point of the map is a wall (K, B) on a one-axis device with dry friction and quantisation, at a rate and a delay. A wall
is stable if none of the certificate's presses and taps leaves a persistent oscillation. The result also contains the
stability boundary of the linear sampled loop and the passivity bound of Colgate and Brown.

The default device is the simulated MTM in its home pose along the axis towards the user.
"""
