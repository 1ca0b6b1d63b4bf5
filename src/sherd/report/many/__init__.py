"""Reports of questions about many shapes."""
