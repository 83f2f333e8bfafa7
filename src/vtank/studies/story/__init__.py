"""The story that `vtank demo` tells: a recording, its simulator, the gap between them, its cause, and the gap closed."""
