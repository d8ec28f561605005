"""The kinds of quantities that vary, a file for each part of a landing."""
