"""Identification: from recordings of a real arm or hand to a model of it."""
