"""The same three steps once more in an arithmetic: in balls, which enclose the exact answer, or in
symbols, which become code.
"""
