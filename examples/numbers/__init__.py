"""Numbers of the pages, made by running their models: ``python -m examples.numbers``."""
