"""One file for each estimate: COMMAND, FORMS, and `trial(form, rng)`."""
