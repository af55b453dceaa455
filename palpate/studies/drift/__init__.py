"""``palpate study drift``: let go of the arm, and see where its gravity compensation lets it drift.

The plant is a simulated MTM that is held as a real one is: a model identified from all recordings of that arm, with
its dry friction, and on top potentials that no controller's form has: "as identified" as large as the recordings
bear out, "rough" as large as all that is left in poses reached both ways, as if none of it were chance.

The controller has seen 160 poses of this plant, with the noise and the friction that recordings show, and nothing
else; the dVRK's form has seen them from both sides, as the dVRK calibrates. Simulated; on a real arm Lin et al. (IROS
2019) published 96 / 60 / 254 mm (mean, median, 95 %) for the paper's form and 5.8 / 2.1 / 22 mm for the dVRK's.
"""
