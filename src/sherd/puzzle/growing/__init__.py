"""Pieces without a whole: groups that grow, and what is known of two surfaces that meet."""
