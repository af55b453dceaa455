"""Ideas of the paper in their simplest form, for reading and for figures. None of them runs in the haptic cycle."""
