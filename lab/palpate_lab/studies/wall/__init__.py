"""``palpate study wall``: Table 1 and Fig 13 of Munawar and Fischer 2016, simulated on the MTM with one hand.

One hand and one loop delay are fitted to the published overshoots of rows 2 and 3; row 1 then oscillates permanently.
docs/wall.md shows alternatives and the sensitivity to each value. The simulation is in ``bench``, the fit in ``fit``.
"""
