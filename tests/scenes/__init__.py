"""What several tests solve: polygons and models of blocks, single steps, joint networks, a model in files.

Benchmarks take their scenes from here too (`large`); no test of the program imports `benchmarks`.
"""
