"""Floor 4: generated shapes and fragments of shapes, both with exact ground truth."""
