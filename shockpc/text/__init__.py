"""Errors, warnings, names and how they are printed, files, TOML, and the record of what ran.

Every other part of the package uses them.
"""
