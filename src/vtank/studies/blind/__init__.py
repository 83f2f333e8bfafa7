"""Blind trials: sealed recordings whose cause is withheld, answers committed by hash, and their score."""
