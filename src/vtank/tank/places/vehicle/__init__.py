"""Effects of the vehicle itself: its centres, its trim, and what pulls or carries all of it."""
