"""Tests, the scenes that they share, and commands of the checkout that take longer than a test may."""
