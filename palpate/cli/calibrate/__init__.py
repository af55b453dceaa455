"""From recordings of an arm to a model of it. `palpate calibrate` lists what can be identified."""

FIRST = ("gravity", "dynamics", "hand", "import", "export")
