"""Floor 6: which vertices of the full shape the part covers."""
