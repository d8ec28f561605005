"""Eq. 4 solved: in double precision for many landings, in ball arithmetic for one, with friction
and over time.
"""
