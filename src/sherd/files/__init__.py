"""Floor 3: reading and writing meshes and point clouds."""
