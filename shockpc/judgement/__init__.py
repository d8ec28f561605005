"""Judgement of profiles: errors, warnings and assumptions; no quantity depends on it."""
