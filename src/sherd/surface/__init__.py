"""Floor 7: one prepared shape for both sides of every question."""
