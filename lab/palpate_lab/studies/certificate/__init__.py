"""``palpate study certificate``: the certificate of a thousand random devices compared with simulation.

The certificate's limit comes from the roots of the sampled loop and a fixed list of presses and taps. The reference
uses neither: it applies random presses and taps to the simulated device, as a wall and as a spring, and finds the limit
by bisection. Stiffnesses that are certified as stable are then tested with new random disturbances.
"""
