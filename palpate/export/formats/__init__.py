"""The formats: one file or folder each, with a function `write(runs, folder, options)`."""
