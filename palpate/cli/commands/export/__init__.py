"""Write what other software reads: data sets (`palpate export RECORD... --to FORMAT --out DIR`), MoveIt 2."""

FIRST = ("records", "moveit")
OTHERWISE = "records"
"""The member that takes arguments that begin with no member's name."""
