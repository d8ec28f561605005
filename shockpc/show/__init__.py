"""Records to tables, files and figures. Computes nothing."""
