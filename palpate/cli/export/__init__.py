"""Write what other software reads: a MoveIt 2 configuration of a scene."""

FIRST = ("moveit",)
