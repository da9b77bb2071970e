"""Bodies made of finite elements: matter, regions, limits and branches of elements."""
