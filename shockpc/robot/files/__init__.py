"""Files of robots: opened inside the open folders, checked for what is not read; a process with limits."""
