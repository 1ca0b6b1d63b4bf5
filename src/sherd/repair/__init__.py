"""Named repairs and what is wrong with a mesh."""
