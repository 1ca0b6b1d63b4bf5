"""Floor 10: the command line."""

from sherd.cli.main import main

__all__ = ["main"]
