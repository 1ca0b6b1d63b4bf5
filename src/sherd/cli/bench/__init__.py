"""`sherd bench` and its commands."""
