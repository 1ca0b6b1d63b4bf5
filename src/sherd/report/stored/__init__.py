"""Result folders, read back."""
