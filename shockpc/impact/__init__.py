"""Solutions of Eq. 4.

They are in double precision for many landings, in ball arithmetic for one, with friction, and over
time.
"""
