"""Steps 1 and 2 once more in an arithmetic: in balls or in symbols.

Balls enclose the exact answer; symbols become code.
"""
