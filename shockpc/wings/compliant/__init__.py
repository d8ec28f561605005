"""Contacts and links that give way: studies of where the rigid answer ceases to hold."""
