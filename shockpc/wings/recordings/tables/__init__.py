"""Tables of recorded landings: columns, rows, scenes of rows, and predictions of what they say."""
