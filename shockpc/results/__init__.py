"""What is derived from the solution of a landing, one kind of number a file, each a pure function of it.

Everything that can lose digits by cancellation is computed in balls and rounded to the nearest double.
"""
