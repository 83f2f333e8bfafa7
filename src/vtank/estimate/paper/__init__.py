"""The paper's own estimators: regression on filtered signals, two-stage and Kalman forms."""
