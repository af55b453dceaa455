"""Look into records, and write parts of them: info, cut, join, repair."""

FIRST = ("info", "cut", "join", "repair")
