"""Identification: models of real arms and hands, fitted to recordings."""
