"""Serve what another process uses: the follower's end of a link, or an emulated network. `palpate serve` lists both."""

FIRST = ("follower", "relay")
