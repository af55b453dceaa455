"""``palpate study wall``: Table 1 and Fig 13 of Munawar and Fischer 2016, on the simulated MTM with one hand.

The published overshoots of rows 2 and 3 fit one hand and one loop delay; row 1 is then an oscillation that does not
end. What else would do the same, and what each value does to the rows, is told beside (docs/wall.md). The simulation
is ``bench``, the search ``fit``.
"""
