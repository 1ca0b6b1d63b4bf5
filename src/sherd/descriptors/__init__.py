"""Floor 6: what neighborhoods look like: SHOT, heat and wave kernel, vocabulary."""
