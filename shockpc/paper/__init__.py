"""The paper that the method comes from: its figures as scenes, its claims as a table of computed values."""
