"""Error against run time of several methods on stiff and extreme landings, and what the package costs.

Nothing else in the package but the command line imports it.
"""
