"""The equations of motion and the numbers that go into them."""
