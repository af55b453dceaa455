"""``palpate study drift``: drift of a released arm under gravity compensation, by form of the gravity model.

The plant is a simulated MTM with the holding torques of a real arm: a model identified from all recordings of this arm,
its dry friction, and additional potentials that no controller's model contains. In the plant "as identified" these
potentials are fitted to the recordings. In the plant "rough" they explain the whole residual of poses that were reached
from both sides.

The controller's model is identified from 160 poses of this plant with the noise and friction of the recordings; the
dVRK's form uses each pose from both sides, as the dVRK's calibration does. Lin et al. (IROS 2019) measured on a real
arm 96 / 60 / 254 mm (mean, median, 95 %) for the paper's form and 5.8 / 2.1 / 22 mm for the dVRK's form.
"""
