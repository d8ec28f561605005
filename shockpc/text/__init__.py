"""What every other room needs: errors, warnings, names and how they are printed, files, TOML, and
the record of what ran.
"""
