"""The method's own paper, computed again: its figures as scenes, its statements as numbers with a verdict each."""
