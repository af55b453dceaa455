"""``palpate study guidance``: effect of virtual fixtures, forces and visual cues on simulated operators.

The operators are models, not people (`palpate.simulators.operators`, with the source of every trait). Each operator
performs four tasks under each condition in closed loop through hand, master arm, haptic cycle with its caps, and
instrument. Effects are relative to the console without assistance, with confidence intervals from a bootstrap over the
operators, and are compared with published effects on people. Registration errors of 1, 2, 3 and 5 mm displace the
guidance from the true path, at which the operators aim; from some error on, guidance is worse than none. The largest
error is the control.
"""
