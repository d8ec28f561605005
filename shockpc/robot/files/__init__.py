"""Files of robots: opened inside the open folders, and checked for what is not read.

Here is also the process with limits.
"""
