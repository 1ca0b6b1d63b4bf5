"""Results of questions about many shapes."""
