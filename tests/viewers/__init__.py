"""The page of ``bsm-mesh view`` in headless Chromium, and the script of ``bsm-mesh paraview`` in ParaView.

``python -m tests.viewers`` says what is missing for them, runs them, and prints sizes and times.
"""
