"""The items of the paper, by subject."""
