"""The linear scheme: small displacements, elastic contacts that cannot fail."""
