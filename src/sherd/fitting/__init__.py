"""The full shape laid onto its pieces: targets, deformation, checks, completion."""
