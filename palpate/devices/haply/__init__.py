"""Haply devices (Inverse3, Minverse, VerseGrip) by the vendor's Inverse Service, and a stand-in of that service."""
