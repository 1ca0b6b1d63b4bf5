"""The benchmark of fits."""
