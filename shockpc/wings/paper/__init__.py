"""The paper of the method: its figures as scenes, its claims as a table of computed values.

J. J. M. Driessen and R. Orsolino, Improving Robustness of Legged Robots Against Mechanical Shock
Using Impulsive Dynamics, Frontiers in Mechanical Engineering 6:601922 (2021), doi
10.3389/fmech.2020.601922. "The shock paper" elsewhere is this one.
"""

HEADING, SUMMARY = "For developers", "Recompute the figures of the paper and check its claims."
