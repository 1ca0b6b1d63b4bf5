"""Floor 12: the command line: words in, words out."""

from sherd.cli.main import main

__all__ = ["main"]
