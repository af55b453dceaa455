"""Identify models of an arm or a hand from recordings. `palpate calibrate` lists the models."""

FIRST = ("gravity", "dynamics", "hand", "import", "export")
