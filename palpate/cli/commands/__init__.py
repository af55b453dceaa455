"""The commands: `palpate NAME` is a file or a folder here, and is imported only when it runs."""
