"""From a name or a file to a `Robot`: found, read inside the open folders, checked, built.

No mechanics.
"""
