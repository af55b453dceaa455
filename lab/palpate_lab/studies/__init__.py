"""Studies: `palpate study NAME` is the folder NAME, with the command in its ``command.py``. Simulated, and said so."""
