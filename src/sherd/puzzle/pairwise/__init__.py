"""What two surfaces share, in any poses, and how likely they belong together."""
