"""The puzzle benchmark."""
