"""Block theory: which blocks at a free face can leave it, how, and with which factor of safety."""
