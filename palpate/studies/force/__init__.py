"""``palpate study force``: force without a sensor, from drive torques, on a real recording and in simulation.

A weight that hangs on a recorded PSM is estimated without its recording having been used before. A simulated PSM is
identified from one motion, then moves differently, touches a floor and is pushed from the side; what the momentum
observer tells is judged by what pushed. docs/dynamics.md tells what the figures mean.
"""
