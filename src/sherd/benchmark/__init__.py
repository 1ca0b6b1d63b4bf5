"""Floor 11: how good the answers are, on data sets and on generated shapes."""
