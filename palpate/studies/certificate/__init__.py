"""``palpate study certificate``: what the certificate says of a thousand random devices, against the simulator.

The certificate's limit comes from the roots of the sampled loop and a fixed list of presses and taps. The judge knows
neither: at each stiffness it throws random presses and taps at the simulated device, as a wall and as a spring, and
halves between a stiffness that rests and one that does not. Then gains that are certified stable are tried with
disturbances that neither has seen. Simulated.
"""
