"""Long runs that judge Palpate: pokes at random meshes, and the haptic node beside the simulated robot."""
