"""What an instrument meets: meshes, surfaces, clouds, soft and rigid bodies, and where each is (frames, registration)."""
