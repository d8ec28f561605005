"""Links that bend, and when links can be taken as rigid."""
