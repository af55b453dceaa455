"""The surgeon's view of a record: what both eyes of the endoscope see, drawn again from the recorded motion."""
