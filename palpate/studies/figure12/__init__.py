"""``palpate study figure12``: the paper's Fig 12, instrument and master arm while four meshes are palpated.

Simulated: hand, both arms and the haptic loop of preset ``paper`` (SPR of 30 mm diameter, 500 Hz). Beside the
instrument in each mesh the master arm with the force on the hand: green in its base axes (spatial), red the same force
in the handle's axes (body), both drawn from the handle.
"""
