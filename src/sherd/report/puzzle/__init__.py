"""The report of a puzzle."""
