"""A motion on springs and dampers whose elements change: mathematics on arrays, with NumPy alone."""
