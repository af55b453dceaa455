"""``palpate study passivity``: does the layer keep its word? Random devices, hands and walls, judged by the simulator.

One axis, simulated exactly (`_core.Axis`): a device with friction and an encoder, held by a random person's hand that
goes in and out of a wall of up to 5000 N/m, with up to 50 ms of delay. The layer is the one of the haptic cycle
(`core/palpate/stability`) and knows what a device knows: counts, the delay, half of the friction. The judge knows the
truth. Of the friction it takes a bound from below, from the true positions x_k at the cycles:

    E_rendered = - integral of F dx                      E_port = E_rendered + sum Fc |dx_k| + b dx_k^2 / T

E_port is what the hand has put into device and wall together; a hand can get energy out of it where E_port falls below
zero. Figures and what they mean: docs/stability-study.md.
"""
