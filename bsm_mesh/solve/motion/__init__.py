"""Explicit damped motion of the blocks: dynamic relaxation to rest, and sliding that is followed."""
