"""One prepared shape for both sides of every question."""
