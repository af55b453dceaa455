"""`palpate check`: one module for each kind of input file."""
