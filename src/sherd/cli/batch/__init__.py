"""`sherd batch`: its command, and tables of parts."""
