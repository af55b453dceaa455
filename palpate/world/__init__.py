"""What an instrument meets: meshes, surfaces, clouds, soft and rigid bodies; frames and registration."""
