"""Error against run time of several methods on hard landings, and the costs of the package.

The landings are stiff and extreme. Nothing else in the package but the command line imports it.
"""

HEADING, SUMMARY = "For developers", "Measure the error and the run time of several methods."
