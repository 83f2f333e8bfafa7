"""The story that `vtank demo` tells: a recording, its simulator, the gap, its cause, and the gap closed."""
