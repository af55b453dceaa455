"""User interface of the commands: terminal output, files, live line, viewer."""

CUT, MISTAKE, INTERRUPTED = 1, 2, 130  # exit codes: a record that ends too early; a mistake of the user; Ctrl-C
PORT = 8080  # default port of the viewer
HOST = "127.0.0.1"  # default address of the viewer
