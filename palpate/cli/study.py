"""Run a study: many simulated runs, one table and one figure. `palpate study` lists the studies."""

MEMBERS = "palpate.studies"  # the folder whose commands these are
