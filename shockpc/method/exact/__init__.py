"""Steps 1 and 2 once more in an arithmetic: in balls, which enclose the exact answer, or in symbols,
which become code.
"""
