"""Floor 6: the energies of the founding paper and their solvers."""
