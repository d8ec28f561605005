"""What differs from landing to landing: variations, their kinds, and the rows they make."""
