"""`python -m sherd` is the command line."""

from sherd.cli.main import main

main()
