"""What a landing or a study found, as text, Markdown, CSV, JSON and a folder of files: one description each."""
