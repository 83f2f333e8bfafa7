"""The gap diagnosis: where the sim-to-real gap lies, which effect causes it, and how far it shrinks."""
