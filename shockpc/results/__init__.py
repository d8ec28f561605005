"""What is read off a solution, one kind of number a file; nothing in here solves anything but what it says."""
