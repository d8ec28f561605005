"""Error against run time of several methods on stiff and extreme landings, and what the package
costs.

Nothing else in the package but the command line imports it.
"""

HEADING, SUMMARY = "For developers", "Measure the error and the run time of several methods."
