"""The paper reproduced: its tables and figures on simulated data, and the study of its estimator's bias."""
