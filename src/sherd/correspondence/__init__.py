"""Floor 8: which point of the full shape is each point of the part."""
