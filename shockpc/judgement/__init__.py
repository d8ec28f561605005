"""Judgement of profiles: errors, warnings and assumptions; nothing below reads it."""
