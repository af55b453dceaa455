"""Virtual fixtures: what guides, forbids and keeps in, made from geometries, roles and laws."""
