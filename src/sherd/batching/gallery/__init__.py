"""One page with a picture of each part."""
