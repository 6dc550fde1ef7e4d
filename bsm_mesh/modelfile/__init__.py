"""The model file: its tables, how a model is built of them, and how one is written."""
