"""Recorded landings: tables of configurations and motions before the impact, and measured jumps against predicted ones."""
