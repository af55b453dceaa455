"""``palpate study pairs``: what each hand of a scene feels alone, and what the other pairs add at shared objects.

Every pair runs alone and together with the others, in lockstep from the same seed. What differs comes from the other
instruments, and from soft tissue that they move. The certificate judges the tool with its surface alone, and with the
instrument of another pair on it, where both stiffnesses add.
"""
