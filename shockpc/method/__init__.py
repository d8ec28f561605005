"""The method of the paper: the impulsive equation of motion, and the jump of every body.

It takes a robot, a posture and what is held. No scene is resolved here, and no file is read.
"""
