"""Records as tables, and tables as text. Computes nothing."""
