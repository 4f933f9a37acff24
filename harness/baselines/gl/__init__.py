"""The same work given to real shader stages of an OpenGL driver: oracle of the kernels, and their rival."""
