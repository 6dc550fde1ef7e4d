"""Commands of the checkout that judge the program and its tests; no test of the program imports them."""
