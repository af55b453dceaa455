"""Items of `palpate reproduce` by the tests that make them."""

AGREE = (
    *(f"eq{k}" for k in (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16, 17, 18, 19, 20)),
    *(f"fig{k}" for k in (3, 6, 7, 8, 9, 10, 11)), "alg1",
)  # fmt: skip
"""Items that agree with the paper and take seconds."""
JUDGED = (*AGREE, "eq12", "table1")
"""Items that tests/reproduce/test_items.py makes."""
LONG = ("fig1", "fig2", "fig4", "fig5", "fig12", "fig13", "approach", "noise", "mesh")
"""All others."""
