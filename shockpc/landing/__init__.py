"""A scene resolved on a robot, as the rows and matrices of Eq. 4.

It has a posture, contacts, loops, a joint model and places.
"""
