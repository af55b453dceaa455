"""Where a command talks to people: its console, its files, its live line, its viewer."""

MISTAKE, INTERRUPTED = 2, 130  # exit codes: a mistake that the user can correct; Ctrl-C
PORT = 8080  # of the viewer, unless --port says another one
