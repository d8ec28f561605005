"""A scene resolved on a robot: posture, contacts, loops, joint model and places, as the rows and
matrices of Eq. 4.
"""
