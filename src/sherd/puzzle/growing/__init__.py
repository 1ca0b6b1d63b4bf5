"""Pieces without a whole: groups that grow from what two surfaces share."""
