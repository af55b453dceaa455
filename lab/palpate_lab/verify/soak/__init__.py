"""Long runs that judge Palpate: pokes at random meshes, random hands, the haptic node beside the simulated robot."""
