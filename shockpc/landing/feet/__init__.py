"""The feet of a landing: which of them strike, and which part of each sole carries it."""
