"""The energies of the founding paper and their solvers."""
