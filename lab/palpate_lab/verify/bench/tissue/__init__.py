"""``palpate bench tissue``: figures of soft bodies, each judged independently. One file holds one kind of figure."""

from palpate_lab.verify.bench.tissue.bodies import POISSON, TICK, YOUNG, Lab, pressed
from palpate_lab.verify.bench.tissue.figures import FIGURES, run, table
from palpate_lab.verify.bench.tissue.layers import layer_cases

__all__ = ["FIGURES", "POISSON", "TICK", "YOUNG", "Lab", "layer_cases", "pressed", "run", "table"]
