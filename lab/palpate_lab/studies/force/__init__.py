"""``palpate study force``: force without a sensor, from drive torques, on a real recording and in simulation.

A weight on a recorded PSM is estimated from a recording that was not used for identification. A simulated PSM is
identified from one motion; in another motion it touches a floor and is pushed from the side. The force of the momentum
observer is compared with the true force. docs/dynamics.md explains the figures.
"""
