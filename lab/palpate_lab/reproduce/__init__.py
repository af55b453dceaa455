"""The paper as a whole: each figure, table and equation computed again and set beside what the paper prints.

`palpate reproduce` runs it. An item (`item.Item`) is a claim of the paper with the function that judges it; the modules
in `items` hold them, `catalogue` puts them in the paper's order, `run` makes and keeps their files, and `page` writes
the HTML page. The computations are those of the studies and the core; this package only compares.
"""
