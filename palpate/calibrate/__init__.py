"""From recordings of a real arm to a model of it."""
