"""What a user states of a landing: a scene, its parts, and files of scenes."""
