"""``palpate study laws``: what the hand feels of a spring, by each control law, slow and fast.

A simulated MTM with its friction and encoders on a bench: a hand moves the handle to and fro, the controller renders
F = -K x, the load cell says what arrives. At the frequency of the motion -F_cell / x is complex: its real part is the
spring that is felt, from which inertia takes m w^2; its imaginary part is friction. Where the spring strays from K by a
tenth, a hand begins to notice. Nothing is in the way but the leader itself: no contact,
no follower. What the figures mean is in docs/torque.md.
"""
