"""One folder for each command: what it computes, its tables, its figures and its options."""
