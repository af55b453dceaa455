import numpy as np

DT = 1e-4  # servo period [s]
Q0 = np.array([0.1, 0.35, -0.15, 0.4, 0.8, 0.2, 0.3])
