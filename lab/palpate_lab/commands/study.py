"""Run a study: many simulated runs, one table and one figure. `palpate study` lists the studies."""

MEMBERS = ("palpate_lab.studies",)  # the folder whose commands these are
