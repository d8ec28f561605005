"""A motion on springs and dampers whose elements change: mathematics on arrays.

It uses NumPy alone.
"""
