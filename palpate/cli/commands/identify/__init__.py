"""Identify what is touched from recordings."""
