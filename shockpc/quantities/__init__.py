"""Every number that a landing has, declared once: its key, unit, title, what it belongs to, and its
formula.
"""
