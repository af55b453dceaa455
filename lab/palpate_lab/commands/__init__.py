"""Commands of the laboratory: `palpate NAME` is a file or a folder here."""
