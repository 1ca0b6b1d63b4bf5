"""Many matches with a known answer: run, measured, summed up, and shown on a page."""
