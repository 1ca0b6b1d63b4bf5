"""The founding paper, reproduced."""
