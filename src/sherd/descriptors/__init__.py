"""Floor 4: heat kernel, wave kernel, SHOT, vocabulary."""
