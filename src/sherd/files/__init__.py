"""Reading and writing meshes and point clouds."""
