"""The vehicle in the tank, in MuJoCo."""
