"""stub"""
from palpate.verify.bench.tissue.rows import Found
def measure(lab, short=False):
    return Found()
