"""Landings that were recorded: a table of touchdowns, measured landings, and drives from logs."""
