"""What two incomplete shapes share: one answer of both directions."""
