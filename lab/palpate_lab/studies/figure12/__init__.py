"""``palpate study figure12``: the paper's Fig 12, instrument and master arm during palpation of four meshes.

Hand, arms and haptic loop are simulated with the preset ``paper`` (SPR of 30 mm diameter, 500 Hz). For each mesh the
picture shows the instrument, and the master arm with the force on the hand: in its base axes (spatial, green) and in
the handle's axes (body, red), both drawn from the handle.
"""
