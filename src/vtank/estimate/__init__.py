"""Identification: the paper's estimators and the maximum-likelihood one."""
