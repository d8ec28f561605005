"""The same three steps once more in ball arithmetic, for one posture: they enclose the exact answer. The only importer of flint."""
