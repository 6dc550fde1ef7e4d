"""Random models with answers that nobody tuned to: ``python -m benchmarks.campaign``, see ``docs/campaign.md``."""
