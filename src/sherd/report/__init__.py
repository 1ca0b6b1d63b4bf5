"""Floor 10: what a person sees and other programs read: pages, pictures, files."""
