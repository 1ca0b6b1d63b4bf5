"""Data sets as pairs with known truth."""
