"""Contacts of moving blocks: the contact set of a step, its forces and tangents, history, transfer between stages."""
