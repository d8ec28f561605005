"""Studies: many landings in, one record out. Each knows `profile.py`, and no other study."""
