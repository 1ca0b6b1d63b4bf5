"""Floor 2: the mesh type, points on it, its geometry and topology."""
