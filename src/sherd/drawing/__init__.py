"""Floor 3: two shapes with colored layers, and pictures of them without a display."""
