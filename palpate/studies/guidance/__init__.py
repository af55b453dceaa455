"""``palpate study guidance``: do virtual fixtures, forces and visual cues help? Simulated operators answer.

They are models, not people (`palpate.operators`, with the source of every trait). Each does four tasks under each
condition, in closed loop through the whole chain: hand, master arm, haptic cycle with its caps, instrument. Effects are
against the console without help, with confidence from a bootstrap over the operators; beside them stands what the
literature says of people. How well must guidance be registered? It is laid beside the truth by 1, 2, 3 and 5 mm: the
operators aim at the true path, and somewhere it makes things worse than none. The last of these is the control.
"""
