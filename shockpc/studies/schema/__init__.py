"""`shockpc schema`."""

HEADING, SUMMARY = "For developers", "Print the JSON Schema of scenes, or of budgets, for editors."
