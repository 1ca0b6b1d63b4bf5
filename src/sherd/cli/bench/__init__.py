"""sherd bench: one command per benchmark."""
