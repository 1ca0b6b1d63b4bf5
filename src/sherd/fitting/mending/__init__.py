"""A fit mended: faces that turned over, surfaces that went through each other."""
