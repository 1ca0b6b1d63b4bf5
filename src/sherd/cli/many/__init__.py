"""`sherd identify`, `template` and `landmarks`: commands for many shapes."""
