"""Pseudo-time continuation: the loop over steps, its strategies, acceptance, stability, verdict; the scheme."""
