"""Floor 8: which vertices of the full shape the part covers."""
