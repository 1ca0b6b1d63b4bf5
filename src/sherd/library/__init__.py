"""Many full shapes: what is cheap to ask each of them, and the folder that keeps them."""
