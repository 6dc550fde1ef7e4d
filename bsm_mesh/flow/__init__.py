"""Steady flow of water in the network of joints: its geometry, the cubic law, free surfaces, pressures on faces."""
