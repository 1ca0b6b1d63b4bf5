"""Floor 4: from what users have to a surface: points, sides, the one door in."""
