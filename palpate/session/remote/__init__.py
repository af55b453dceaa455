"""Two processes of one teleoperation: the follower's end (`site`), and the link of a session to it (`link`)."""
