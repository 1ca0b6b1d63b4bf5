"""Floor 7: what users get: placements, results, options, values carried along."""
