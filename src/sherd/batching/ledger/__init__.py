"""What is known of each task, in files that any number of processes may write to."""
