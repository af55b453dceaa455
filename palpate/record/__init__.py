"""Records of a session: the table of signals, MCAP files, replay."""
