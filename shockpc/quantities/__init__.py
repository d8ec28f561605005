"""The numbers of a landing, each declared once: key, unit, title, kind of place and formula."""
