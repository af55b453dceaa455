"""``palpate study laws``: impedance at the hand of a rendered spring, by control law and frequency.

A hand oscillates the handle of a simulated MTM with friction and encoders. The controller renders F = -K x, and a load
cell measures the force on the hand. At the frequency of the motion, -F_cell / x is complex. Its real part is the
stiffness at the hand, reduced by the inertia term m w^2; its imaginary part is due to friction. A deviation of 10 %
from K is noticeable. The study contains only the leader: no contact and no follower (docs/torque.md).
"""
