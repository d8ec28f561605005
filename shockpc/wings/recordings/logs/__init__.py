"""Landings that were recorded: tables, logs and bags, their columns, rows and predictions."""
