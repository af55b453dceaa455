"""Ideas of the paper in their simplest form, to be read and drawn. Nothing here runs in the haptic cycle."""
