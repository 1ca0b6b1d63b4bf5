"""Floor 2: the one mesh type, points on it, files, validation, repair."""
