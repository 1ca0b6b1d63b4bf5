"""Floor 8: what a person sees and other programs read: pages, pictures, files."""
