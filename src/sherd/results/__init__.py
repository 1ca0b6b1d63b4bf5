"""What users get: placements, results, options, and values carried along them."""
