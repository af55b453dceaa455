"""User interface of the commands: terminal output, files, live line, viewer."""

MISTAKE, INTERRUPTED = 2, 130  # exit codes: a mistake that the user can correct; Ctrl-C
PORT = 8080  # default port of the viewer
HOST = "127.0.0.1"  # default address of the viewer
