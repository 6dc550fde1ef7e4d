"""Campaigns: a million of faulty inputs, runs that are killed, disks that are full (docs/campaigns.md).

They are commands of the checkout, not tests: ``python -m tools.campaigns --help``. A short slice of each runs as a test
(tests/unit/test_campaigns.py).
"""
