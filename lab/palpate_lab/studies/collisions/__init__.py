"""``palpate study collisions``: the paper's Fig 5, contacts of a moving instrument with the meshes of a scene."""
