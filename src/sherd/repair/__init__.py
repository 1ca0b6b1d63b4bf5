"""Floor 3: named repairs, and what is wrong with a mesh."""
