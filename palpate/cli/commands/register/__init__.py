"""Find the pose between two frames from measurements, and its predicted error. `palpate register` lists the ways."""

FIRST = ("session", "check", "points", "surface", "handeye", "camera", "pivot")
