"""Several pieces on one whole: which placements go together, who has which place, borders."""
