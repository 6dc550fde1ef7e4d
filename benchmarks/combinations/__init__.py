"""Random combinations of features on a small wall: each has an answer that holds, or a message."""
