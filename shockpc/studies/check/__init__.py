"""The check of budgets: are the numbers of some landings within limits, and within a tolerance of those of an earlier design?"""
