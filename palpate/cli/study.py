"""Studies: many runs, one table and one picture. `palpate study` lists them."""

MEMBERS = "palpate.studies"  # the folder whose commands these are
