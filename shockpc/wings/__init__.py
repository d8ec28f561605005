"""Subjects that can be taken away: each folder is one, and nothing else needs it."""
