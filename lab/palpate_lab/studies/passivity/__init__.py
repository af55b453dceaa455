"""``palpate study passivity``: test of the passivity layer on random devices, hands and walls in simulation.

One axis is simulated exactly (`_verify.Axis`): a device with friction and an encoder, held by a random hand that moves
in and out of a wall of up to 5000 N/m with up to 50 ms of delay. The layer is that of the haptic cycle
(`core/palpate/stability`). It uses only data that a device has: encoder counts, the delay and half of the friction. The
evaluation uses the true positions x_k at the cycles, which give a lower bound of the energy lost to friction:

    E_rendered = - integral of F dx                      E_port = E_rendered + sum Fc |dx_k| + b dx_k^2 / T

E_port is the energy that the hand has put into device and wall together. A negative E_port means that the hand has
extracted energy. docs/stability-study.md explains the figures.
"""
