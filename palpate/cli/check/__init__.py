"""`palpate check`: one file for each kind of file that it looks at."""
