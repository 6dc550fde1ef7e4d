"""Block-Spring Model."""
