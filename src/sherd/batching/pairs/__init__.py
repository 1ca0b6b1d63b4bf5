"""All pairs of a collection: what each two of its shapes share."""
