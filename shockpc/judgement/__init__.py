"""How far to trust a profile, and what it takes for granted: it reads profiles, and nothing below
knows it.
"""
