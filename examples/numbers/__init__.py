"""Numbers of the pages, made by running what they tell of: ``python -m examples.numbers``."""
