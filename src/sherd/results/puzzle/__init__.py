"""What users get of a puzzle, and its options."""
