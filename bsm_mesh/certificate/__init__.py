"""Certificates of verdicts: written and read; `verify_certificate` checks them apart."""
