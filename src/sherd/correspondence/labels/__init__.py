"""A label of the full shape for each node of the part, jointly."""
