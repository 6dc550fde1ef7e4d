"""Mutation score of ``bsm_mesh/contact`` and ``bsm_mesh/solve``, from a sample (docs/mutation.md).

A command of the checkout, not a test: ``python -m tests.mutation --help``.
"""
