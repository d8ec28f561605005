"""The reader of URDFs."""
